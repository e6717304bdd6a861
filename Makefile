# Two commands on a fresh machine: `make demo` and `make test`. PYTHON=... chooses the interpreter.

SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help

BIN := .venv/bin
DEMO := runs/demo
WORKERS := -n logical --maxprocesses 4 --dist worksteal

export OMP_NUM_THREADS := 1
export PYRIGHT_PYTHON_IGNORE_WARNINGS := 1
export NO_MKDOCS_2_WARNING := 1
# Containers often set it; then each new process compiles some 3,000 modules again, for seconds.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: help demo cameras test test-all check format docs lock bench

help:
	@echo "make demo    set up everything it needs and run one whole procedure"
	@echo "make cameras fetch a software renderer if this machine has no renderer; needs no root"
	@echo "make test    set up everything it needs and pass the tests"
	@echo "make test-all the slow tests too: some minutes more"
	@echo "make check   format, lint, types, import direction"
	@echo "make format  rewrite the code in the project's format"
	@echo "make docs    build the documentation in build/docs"
	@echo "make bench   speed of each stage of the world"
	@echo "make lock    resolve requirements.lock again"

demo: .venv/.ready
	shows="--video $(DEMO)/endoscope.mp4 --captions"
	if ! $(BIN)/python -c "from tissue_sim.rendering import renderer; exit(not renderer.renderer_available())"; then
	  echo "There is no renderer here, so there is no video (make cameras fetches one)."
	  shows=
	fi
	$(BIN)/calot run $$shows --out $(DEMO)

cameras: .venv/.ready
	@bash tissue_sim/rendering/fetch_renderer.sh $(BIN)/python

test: .venv/.ready
	$(BIN)/pytest $(WORKERS)

test-all: .venv/.ready
	$(BIN)/pytest $(WORKERS) -m "slow or not slow"

check: .venv/.ready
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright
	$(BIN)/lint-imports

format: .venv/.ready
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

docs: .venv/.ready
	$(BIN)/mkdocs build --strict --quiet

bench: .venv/.ready
	$(BIN)/calot bench world

# --- set-up ---

# A pyenv shim can exist and still fail, so each candidate is run.
define FIND_PYTHON
for python in $${PYTHON:-python3.12 python3.11 python3}; do \
  if "$$python" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 13))' 2>/dev/null; \
  then break; fi; python=; \
done; \
if [ -z "$$python" ]; then \
  echo "Python 3.11 or 3.12 is needed (tried: $${PYTHON:-python3.12 python3.11 python3});" \
       "name one with PYTHON=..." >&2; exit 1; \
fi
endef

.ONESHELL:

# Where the system's Python has no ensurepip, its own pip fills the environment from outside. uv does
# it in a quarter of pip's time; pip does it where only pip is told how to reach the registry.
.venv/.ready: requirements.lock pyproject.toml
	@$(FIND_PYTHON)
	"$$python" -m venv .venv >/dev/null 2>&1 || "$$python" -m venv --without-pip .venv
	pip="$(BIN)/python -m pip"
	$$pip --version >/dev/null 2>&1 || pip="$$python -m pip --python $(BIN)/python"
	echo "Setting up .venv with $$("$$python" --version): about 3 GB to download the first time"
	pip="$$pip install --quiet --disable-pip-version-check --require-hashes"
	awk '/^uv==/,!/\\$$/' requirements.lock >.venv/uv.txt
	$$pip -r .venv/uv.txt
	$(BIN)/uv pip install --python $(BIN)/python --system-certs --quiet --require-hashes \
	  -r requirements.lock || $$pip --no-compile -r requirements.lock
	$(BIN)/uv pip install --python $(BIN)/python --quiet --no-deps --no-build-isolation -e .
	touch $@

lock:
	@$(FIND_PYTHON)
	uv=$$(mktemp -d)
	trap 'rm -rf "$$uv"' EXIT
	"$$python" -m venv "$$uv"
	"$$uv/bin/python" -m pip install --quiet --disable-pip-version-check uv
	"$$uv/bin/uv" pip compile --system-certs --universal --python-version 3.11 --extra dev \
	  --generate-hashes --no-emit-index-url --no-annotate --no-header --quiet \
	  --output-file requirements.lock pyproject.toml
