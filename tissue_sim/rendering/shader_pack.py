"""Edit SAPIEN's own shader pack 'minimal' at run time for an endoscope.

The pack has no image-based lighting (an environment map and a table that take seconds to prepare),
so the first picture comes at once. It adds the clear film of liquid on tissue and tools, and the
reflection of tissue in steel. Short shadows are found in the depth picture. It also adds a filmic
tone curve in place of clipping, softened edges, dark corners, and positions in micrometres instead
of millimetres.

A clear surface lets through a share of the pixels behind it. They form a fine pattern ("interleaved
gradient noise", Jimenez, 2014), which the softened edges blur. The share is the material's
transmission, which 'minimal' does not use.

The film needs two numbers that 'minimal' does not use. The fourth component of a material's
emission is 1 less the share of the surface under the film. The fourth component of a relief is the
place where the film stays.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import sapien

from tissue_sim.cached_files import cached_folder
from tissue_sim.rendering.textures import BLURRED_RELIEF

PACK = "field"
COLOR_PICTURE = "Color"  # (H, W, 4) uint8
POSITION_PICTURE = "MicrometrePosition"  # (H, W, 4) int32: camera x right, y up, z back; entity
MICROMETRE = 1.0e-6
PICTURE_FORMATS = {
    COLOR_PICTURE: "r8g8b8a8unorm",
    "ColorRaw": "r8g8b8a8unorm",
    POSITION_PICTURE: "r32g32b32a32sint",
}

_ENVIRONMENT_BINDING = r"layout\(set = \d, binding = [78]\)[^\n]*\n"
_FUNCTION = r"vec3 {}\(.*?\n}}\n"

_TANGENTS = """\
const float FILM_ALPHA2 = 0.0065;  // assumed: as wide as the ring of fibres that is mirrored
const float FILM_FRESNEL = 0.10;  // water has 0.02; assumed: highlights dazzle and bloom

mat3 tangentFrame(vec3 n) {
  vec3 along = dFdx(inPosition.xyz), down = dFdy(inPosition.xyz);
  vec2 u = dFdx(inUV), v = dFdy(inUV);
  vec3 t = cross(down, n) * u.x + cross(n, along) * v.x;
  vec3 b = cross(down, n) * u.y + cross(n, along) * v.y;
  float scale = inversesqrt(max(max(dot(t, t), dot(b, b)), 1e-20));
  return mat3(t * scale, b * scale, n);
}

void main()"""  # Schueler, "Followup: normal mapping without precomputed tangents", 2013
_BUMP = """\
  if (materialBuffer.transmission > 0.0) {
    float chance = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    if (chance < materialBuffer.transmission) discard;
  }
  float pooled = 1.0;
  vec3 rippled = normalize(inTbn[2]);
  if ((materialBuffer.textureMask & 4) != 0) {
    vec4 bump = texture(normalTexture, inUV);
    pooled = bump.a;
    rippled = normalize(tangentFrame(rippled) * (bump.xyz * 2 - 1));
  }
  // Liquid shows every ripple; light that has been inside the tissue blurs them.
  vec3 normal = normalize(mix(normalize(inTbn[2]), rippled, BLURRED));
""".replace("BLURRED", str(BLURRED_RELIEF))
_FILM = """\
  float film = max(1.0 - materialBuffer.emission.a, min(1.2 * metallic, 0.8));  // wet tools
  if (film > 0.0) {  // water's reflection of the lamp: GGX, with what it is near the mirror angle
    vec3 l = world2camera(vec4(sceneBuffer.pointLights[0].position.xyz, 1.f)).xyz - csPosition.xyz;
    vec3 across = normalize(normalize(l) + camDir);
    rippled = normalize(rippled + max(0.3 - dot(rippled, camDir), 0.0) * camDir);
    float NoH = max(dot(rippled, across), 0.0);
    float spread = 1.0 - NoH * NoH * (1.0 - FILM_ALPHA2);
    float mirror = film * pooled * FILM_FRESNEL * FILM_ALPHA2 / (12.566370614 * spread * spread);
    color += sceneBuffer.pointLights[0].emission.rgb * mirror / dot(l, l);
  }
"""
_OUTLINE = """\
  vec3 camDir = -normalize(csPosition.xyz);
  if (metallic > 0.0) {  // drops and smears of liquid on a tool
    vec3 q = 1100.0 * objectCoord;
    vec3 smear = sin(q.yzx + 1.7 * sin(0.61 * q)) + 0.6 * sin(2.3 * q.zxy + 2.0 * sin(1.3 * q));
    rippled = normalize(rippled + 0.16 * smear);
    normal = normalize(normal + 0.05 * smear);
  }
  // At an outline the surface's back shows and light grazes: bend the normal towards the eye.
  normal = normalize(normal + max(0.3 - dot(normal, camDir), 0.0) * camDir);
"""
_SHEEN = """\
  float rim = 1.0 - max(dot(normal, camDir), 0.0);
  vec3 soft = albedo.rgb * (1.0 - 0.5 * rim) + specular * rim * rim;
  color += mirrored + sceneBuffer.ambientLight.rgb * soft;
"""
_METAL = """\
  vec3 diffuseAlbedo = albedo.rgb * (1 - metallic) * (1 - metallic);
  // Steel mirrors the lit tissue ahead of the endoscope, and the dark behind it.
  float ahead = smoothstep(-0.5, 0.7, reflect(camDir, normal).z);
  vec3 mirrored = metallic * albedo.rgb * mix(vec3(0.05), vec3(0.32, 0.25, 0.23), ahead);
"""
_FILMIC = """\
  float peak = max(max(color.r, color.g), max(color.b, 1e-4));  // by the peak: keeps the hue
  color *= (2.51 * peak + 0.03) / (peak * (2.43 * peak + 0.59) + 0.14);
  outColorRaw = vec4(pow(clamp(color, vec3(0), vec3(1)), vec3(1/2.2)), albedo.a);
"""  # Narkowicz, "ACES filmic tone mapping curve", 2015
_SOFT_DIFFUSE = """\
float diffuse(float NoL) {  // light enters tissue and leaves beside: no hard shadow edge
  return max((NoL + 0.2) / 1.2, 0.0) / 3.141592653589793f;
}"""
_LAMPS = """\
const float WEAK = 0.01;  // W/sr, all colours: less has the wrists' lamps alone
const float REACH2 = 0.055 * 0.055;  // m2, assumed: beyond, a weak lamp is outshone

float diffuse("""
_WIDE_LAMP = """\
  if (dot(emission, vec3(1)) < WEAK) {  // fades out, so that no pixel far away computes it
    emission *= clamp(1.5 - 1.5 * dot(l, l) / REACH2, 0, 1);
    if (dot(l, l) > REACH2) return vec3(0);
  }
  // assumed: a ring of fibres with a wide beam dazzles less nearby than a point would
  float d = sqrt(dot(l, l) + 0.025 * 0.025);"""
_POSITION = f"  out{POSITION_PICTURE} = ivec4(ivec3(inPosition * 1e6), inSegmentation[1]);\n"

_COMPOSITE = """\
float luma(vec3 c) { return dot(c, vec3(0.299, 0.587, 0.114)); }

vec3 tap(vec2 offset) {
  vec2 pixel = 1.0 / vec2(cameraBuffer.width, cameraBuffer.height);
  return texture(samplerColorRaw, inUV + offset * pixel).rgb;
}

// Edges smoothed along their direction: Lottes, "FXAA", 2009, in its shortest form.
vec3 smoothed() {
  vec3 here = tap(vec2(0));
  float nw = luma(tap(vec2(-1, -1))), ne = luma(tap(vec2(1, -1)));
  float sw = luma(tap(vec2(-1, 1))), se = luma(tap(vec2(1, 1)));
  float m = luma(here);
  float low = min(m, min(min(nw, ne), min(sw, se)));
  float high = max(m, max(max(nw, ne), max(sw, se)));
  if (high - low < max(0.03, 0.1 * high)) return here;
  vec2 along = vec2((sw + se) - (nw + ne), (nw + sw) - (ne + se));
  float dim = max(0.03125 * (nw + ne + sw + se), 0.0078125);
  along = clamp(along / (min(abs(along.x), abs(along.y)) + dim), -8.0, 8.0);
  vec3 narrow = 0.5 * (tap(along * -0.16667) + tap(along * 0.16667));
  vec3 wide = 0.5 * narrow + 0.25 * (tap(along * -0.5) + tap(along * 0.5));
  return luma(wide) < low || luma(wide) > high ? narrow : wide;
}

const int LOOKS = 4;
const float FIRST_M = 0.0006, STEP_M = 0.0022;  // of the way to the lamp: up to 9 mm
const float FARTHEST_M = 0.15;  // from the camera: farther shadows are smaller than a pixel
const float SHADE = 0.5;  // assumed: what remains is light that tissue reflects

float up(vec2 uv) {  // of the surface in a pixel: along the camera's z axis, which points back
  mat4 m = cameraBuffer.projectionMatrixInverse;
  float depth = texture(samplerGbufferDepth, uv).x;
  return (m[2][2] * depth + m[3][2]) / (m[2][3] * depth + m[3][3]);
}

// Does something seen lie before the lamp? "Contact shadows": a short walk over the depth picture.
float lit() {
  vec2 ray = (2.0 * inUV - 1.0)
    * vec2(cameraBuffer.projectionMatrixInverse[0][0], cameraBuffer.projectionMatrixInverse[1][1]);
  float z = up(inUV);
  if (z < -FARTHEST_M) return 1.0;
  vec3 here = vec3(-z * ray, z);
  vec3 lamp = (cameraBuffer.viewMatrix * vec4(sceneBuffer.pointLights[0].position.xyz, 1.0)).xyz;
  vec3 way = normalize(lamp - here);
  vec4 start = cameraBuffer.projectionMatrix * vec4(here, 1.0);
  vec4 ahead = cameraBuffer.projectionMatrix * vec4(way, 0.0);
  float chance = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
  float far_m = FIRST_M + chance * STEP_M, shadow = 0.0;  // by chance: no bands
  for (int k = 0; k < LOOKS; ++k) {
    vec4 clip = start + far_m * ahead;
    float before = up(0.5 + 0.5 * clip.xy / clip.w) - z - far_m * way.z;  // nearer to the camera
    float hit = smoothstep(0.0007, 0.0018, before) * (1.0 - smoothstep(0.009, 0.014, before));
    shadow = max(shadow, hit * (1.0 - float(k) / float(LOOKS + 2)));
    far_m += STEP_M;
  }
  return 1.0 - SHADE * shadow;
}

void main() {
  vec2 off = 2.0 * inUV - 1.0;
  float aside = dot(off, off);
  float vignette = 1.0 - 0.18 * aside - 0.08 * aside * aside;
  outColor = vec4(smoothed() * (lit() * vignette), 1.0);
}
"""


@cache
def shader_pack() -> Path:
    """Return the pack's folder in the cache."""
    source = Path(sapien.__file__).parent / "vulkan_shader"
    files = {
        f"{folder}/{path.relative_to(source / original)}": path.read_text()
        for folder, original in (("common", "common"), (PACK, "minimal"))
        for path in (source / original).rglob("*")
        if path.is_file()
    }
    for name, edit in _EDITS.items():
        files[name] = edit(files[name])
    encoded = {name: text.encode() for name, text in files.items()}
    return cached_folder("shaders", encoded) / PACK


def set_picture_formats() -> None:
    """Register the pictures' formats by name with SAPIEN, for the whole process."""
    for name, picture_format in PICTURE_FORMATS.items():
        sapien.render.set_picture_format(name, picture_format)


def _light(text: str) -> str:
    text = _replaced(text, r"float diffuse\(float NoL\) \{[^}]*\}", _SOFT_DIFFUSE)
    text = _replaced(text, r"float diffuse\(", _LAMPS)
    text = _replaced(text, r"  float d = max\(length\(l\), 0.0001\);", _WIDE_LAMP, count=3)
    return _replaced(
        text, r"diffuse\(NoL\) / d / d", "diffuse(dot(normal, lightDir)) / d / d", count=3
    )


def _surface(text: str) -> str:
    for function in ("getBackgroundColor", "diffuseIBL", "specularIBL"):
        text = _replaced(text, _FUNCTION.format(function), "")
    text = _replaced(text, _ENVIRONMENT_BINDING, "", count=2)
    text = _replaced(text, r"void main\(\)", _TANGENTS)
    text = _replaced(text, r"  vec3 normal;\n  if \(objectDataBuffer.*?\n  }\n(?=\n)", _BUMP)
    text = _replaced(text, r"  vec3 camDir = [^\n]*\n", _OUTLINE)
    text = _replaced(text, r"  vec3 diffuseAlbedo = [^\n]*\n", _METAL)
    text = _replaced(text, r"  vec3 wnormal = .*?camDir\);\n", "")
    text = _replaced(text, r"  color \+= sceneBuffer\.ambientLight[^\n]*\n", _FILM + _SHEEN)
    text = _replaced(text, r"  outColorRaw = [^\n]*\n", _FILMIC)
    text = _replaced(text, r"  outPositionSegmentation = [^\n]*\n", _POSITION)
    return _replaced(text, r"ivec4 outPositionSegmentation", f"ivec4 out{POSITION_PICTURE}")


def _picture(text: str) -> str:
    text = _replaced(text, _ENVIRONMENT_BINDING, "", count=2)
    return _replaced(text, r"vec3 getBackgroundColor.*", _COMPOSITE)


def _vertex(text: str) -> str:
    """Rotate normals as points are rotated, because no drawn surface is stretched."""
    return _replaced(text, r"mat3\(transpose\(inverse\(modelView\)\)\)", "mat3(modelView)")


_EDITS = {
    "common/lights.glsl": _light,
    f"{PACK}/gbuffer.vert": _vertex,
    f"{PACK}/gbuffer.frag": _surface,
    f"{PACK}/composite0.frag": _picture,
}


def _replaced(text: str, pattern: str, new: str, *, count: int = 1) -> str:
    """Replace a pattern that must occur `count` times in the text."""
    text, found = re.subn(pattern, lambda _: new, text, flags=re.DOTALL)
    if found != count:
        raise RuntimeError(f"SAPIEN {sapien.__version__}: its shaders differ: no {pattern!r}")
    return text
