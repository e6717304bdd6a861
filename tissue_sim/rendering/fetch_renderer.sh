#!/usr/bin/env bash
# Fetch Mesa's software renderer from this machine's own package sources, without root:
#
#     fetch_renderer.sh PYTHON    into the folder `renderer` of this Python's environment
#
# `make cameras` runs this file. Nothing outside that folder is written: apt works on private lists
# and a private cache, and packages are unpacked instead of installed. Mesa before 24.3 does not
# suffice, so the backports of the machine's release are used too, at the same address.
set -euo pipefail

here=$(cd "${BASH_SOURCE[0]%/*}" && pwd)
base='libc6|libgcc-s1|libstdc[+][+]6|gcc-[0-9]+-base|libcrypt1' # Python and SAPIEN load them first
driver=libvulkan_lvp.so

fail() { echo "E: $1" >&2; exit 1; }

# Run a program for at most $1 seconds: a machine without network must not be kept waiting.
within() { timeout "$@" || { [ $? != 124 ] || echo "E: $2 was not done in $1 s" >&2; return 1; }; }

# Print the first line of a log that states an error; later lines follow from it.
complaint() {
  awk '/^E:|Failed to fetch/ { found = substr($0, 4); exit } NR == 1 { first = $0 }
       END { print found ? found : first ? first : "it failed and did not say why" }' "$1"
}

# Print package sources (file $2) with the suite of release $1 replaced by its backports; nothing if
# they do not name the release. A file has a line or, in `.sources`, a stanza for each source.
backports() {
  case $2 in
    *.list) sed -nE "s/^(deb\s+(\[[^]]*\]\s+)?\S+\s+$1)(\s.*)$/\1-backports\3/p" "$2" ;;
    *.sources) awk -v release="$1" 'BEGIN { RS = "" } { stanza = "\n" $0 "\n" }
      stanza ~ "\nTypes:[^\n]*[: \t]deb[ \t\n]" &&
      sub("\nSuites:([^\n]*[ \t])?" release "([ \t][^\n]*)?\n",
          "\nSuites: " release "-backports\n", stanza) { print stanza }' "$2" ;;
  esac
}

# Download the driver's package and all its dependencies beyond `base` to folder $1/cache/archives.
download() {
  local release file
  release=$(. /etc/os-release && echo "${VERSION_CODENAME:-}")
  mkdir -p "$1"/{sources,state/lists/partial,cache/archives/partial}
  for file in /etc/apt/sources.list /etc/apt/sources.list.d/*; do
    [[ $file =~ \.(list|sources)$ && -r $file ]] || continue
    { cat "$file"; echo; backports "$release" "$file"; } >"$1/sources/${file##*/}"
  done
  grep -q -- "$release-backports" "$1"/sources/* \
    || fail "no package source of the release '$release' in /etc/apt"
  awk -v base="^Package: ($base)\n" 'BEGIN { RS = ""; ORS = "\n\n" } $0 ~ base' \
    /var/lib/dpkg/status >"$1/status"
  cat >"$1/apt.conf" <<END
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
Dir::Etc { SourceList "/dev/null"; SourceParts "$1/sources"; };
Dir::State "$1/state";
Dir::State::Lists "$1/state/lists";
Dir::State::Status "$1/status";
Dir::Cache "$1/cache";
Dir::Cache::Archives "$1/cache/archives";
Debug::NoLocking "true";
APT::Sandbox::User "";
APT::Install-Recommends "false";
Acquire { Languages "none"; Retries "1"; http::Timeout "10"; https::Timeout "10"; };
END
  local apt=(apt-get -c "$1/apt.conf" -qq -y)
  within 60 "${apt[@]}" update || true
  apt+=(install --download-only --target-release "$release-backports" mesa-vulkan-drivers)
  within 600 "${apt[@]}"
}

# Print the names of a library's dependencies that are in its own folder.
needs() { LD_LIBRARY_PATH=${1%/*} ldd "$1" | sed -nE "s#.* => ${1%/*}/(\S+) .*#\1#p"; }

# Copy the driver and its dependencies from unpacked packages $1 to $2, as `renderer.py` reads them.
arrange() {
  local all=$1/everything name
  mkdir -p "$all" "$2/lib"
  find "$1" -name '*.so*' ! -path "$all/*" -exec ln -sf -t "$all" {} +
  [ -e "$all/$driver" ] || fail "the package mesa-vulkan-drivers holds no $driver"
  # A library's dependencies are a part of its user's, so their number gives the order of loading.
  for name in $(needs "$all/$driver"); do
    echo "$(needs "$all/$name" | wc -l) lib/$name"
  done | sort -n | cut -d' ' -f2 >"$2/libraries.txt"
  for name in $(cat "$2/libraries.txt") "lib/$driver"; do
    cp -L "$all/${name#lib/}" "$2/lib/"
  done
  echo "{\"file_format_version\": \"1.0.0\", \"ICD\":" \
    "{\"library_path\": \"./lib/$driver\", \"api_version\": \"1.3.0\"}}" >"$2/driver.json"
}

# Put the renderer in folder $1, in place of its content, or say in one line why not.
fetch() {
  local program package why
  for program in apt-get dpkg ldd; do
    command -v "$program" >/dev/null && continue
    echo "No renderer: only Debian and its like are served, and $program is not here." >&2
    exit 1
  done
  log=$(mktemp)
  exec 3>&2 2>"$log"
  trap '[ $? = 0 ] || echo "No renderer: $(complaint "$log")." >&3; rm -rf "$log" "${root:-}"' EXIT
  mkdir -p "${1%/*}"
  root=$(mktemp -d "${1%/*}/.renderer-XXXXXX")
  download "$root"
  for package in "$root"/cache/archives/*.deb; do
    why=$(within 120 dpkg -x "$package" "$root/unpacked" 2>&1) \
      || fail "${package##*/} cannot be unpacked: ${why%%$'\n'*}"
  done
  arrange "$root/unpacked" "$root/renderer"
  rm -rf "$1"
  mv "$root/renderer" "$1"
}

# Fetch a renderer for a Python if none works here.
main() {
  local folder kind variable
  folder=$("$1" -c 'import sys; print(sys.prefix)')/renderer
  if kind=$("$1" -P "$here/renderer.py" 2>/dev/null | tail -n 1); then
    echo "A renderer works here ($kind); nothing to fetch."
    return
  fi
  for variable in VK_DRIVER_FILES VK_ICD_FILENAMES VK_ADD_DRIVER_FILES; do
    if [ "${!variable-$folder/driver.json}" != "$folder/driver.json" ]; then
      echo "No renderer: $variable names a driver that does not work." >&2
      exit 1
    fi
  done
  echo "Fetching Mesa's software renderer (about 50 MB) ..."
  fetch "$folder"
  "$1" -P "$here/renderer.py" >/dev/null && { echo "The renderer is in $folder."; return; }
  rm -rf "$folder"
  fail "the one in the package sources does not work with SAPIEN"
}

[ "${BASH_SOURCE[0]}" != "$0" ] || main "$@"
