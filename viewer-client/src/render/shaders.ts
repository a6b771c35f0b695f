/** GLSL: geometry, shading from the table, tones, and the colour difference of two images. */

/** Lights that one draw call adds. */
export const LIGHTS_AT_ONCE = 32;

export const FULL_SCREEN = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

/** The normal of a unit sphere seen along +z in orthographic projection; w is coverage. */
export const SPHERE_NORMALS = `#version 300 es
precision highp float;
uniform vec2 centre;
uniform float radius;
out vec4 normal;
void main() {
  vec2 p = (gl_FragCoord.xy - centre) / radius;
  float r = length(p);
  float coverage = clamp((1.0 - r) * radius + 0.5, 0.0, 1.0);
  p *= min(1.0, 0.9999 / max(r, 1e-6));
  normal = vec4(p, sqrt(max(0.0, 1.0 - dot(p, p))), coverage);
}`;

export const MESH_VERTICES = `#version 300 es
precision highp float;
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 facing;
uniform mat3 turn;
uniform vec2 extent;
out vec3 toward;
void main() {
  vec3 p = turn * place;
  toward = turn * facing;
  gl_Position = vec4(p.xy * extent, -0.4 * p.z, 1.0);
}`;

export const MESH_NORMALS = `#version 300 es
precision highp float;
in vec3 toward;
out vec4 normal;
void main() {
  vec3 n = normalize(toward);
  if (n.z < 1e-4) n = normalize(vec3(n.xy, 1e-4));
  normal = vec4(n, 1.0);
}`;

// Rusinkiewicz coordinates as in docs/conventions.md, without building a frame.
export const SHADE = `#version 300 es
precision highp float;
precision highp sampler3D;
const float PI = 3.14159265358979;
uniform sampler2D normals;
uniform sampler3D brdf;
uniform sampler2D albedo;
uniform vec3 grid;
uniform float scale;
uniform int count;
uniform vec3 direction[${LIGHTS_AT_ONCE}];
uniform vec3 irradiance[${LIGHTS_AT_ONCE}];
uniform vec3 surround;
out vec4 colour;

vec3 lookUp(vec3 n, vec3 l, vec3 v) {
  vec3 both = l + v;
  vec3 h = normalize(both);
  float cosH = dot(n, h);
  vec3 along = h - n * cosH;
  float sinH = length(along);
  float thetaH = atan(sinH, cosH);
  float thetaD = atan(length(l - v), length(both));
  float phiD = 0.0;
  if (sinH > 1e-6 && thetaD > 1e-6) {
    vec3 t = along / sinH;
    float x = cosH * dot(l, t) - sinH * dot(l, n);
    float y = dot(l, cross(n, t));
    phiD = atan(y, x);
    if (phiD < 0.0) phiD += PI;
  }
  vec3 at = vec3(phiD / PI, thetaD / (PI / 2.0), sqrt(max(thetaH, 0.0) / (PI / 2.0)));
  return textureLod(brdf, at + 0.5 / grid, 0.0).rgb * scale;
}

vec3 albedoAt(float cosine) {
  float last = float(textureSize(albedo, 0).x - 1);
  float at = clamp((cosine - 0.02) / 0.98, 0.0, 1.0) * last;
  int below = int(min(floor(at), last - 1.0));
  vec3 a = texelFetch(albedo, ivec2(below, 0), 0).rgb;
  vec3 b = texelFetch(albedo, ivec2(below + 1, 0), 0).rgb;
  return mix(a, b, at - float(below));
}

void main() {
  vec4 surface = texelFetch(normals, ivec2(gl_FragCoord.xy), 0);
  if (surface.w <= 0.0) discard;
  vec3 n = surface.xyz;
  vec3 v = vec3(0.0, 0.0, 1.0);
  vec3 sum = vec3(0.0);
  for (int i = 0; i < count; i++) {
    float cosine = dot(n, direction[i]);
    if (cosine <= 1e-6) continue;
    sum += lookUp(n, direction[i], v) * irradiance[i] * cosine;
  }
  if (surround.r + surround.g + surround.b > 0.0) sum += surround * albedoAt(n.z);
  colour = vec4(sum, 0.0);
}`;

const SRGB = `
vec3 encode(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}`;

/** Linear light to the screen. */
export const TONES = `#version 300 es
precision highp float;
uniform sampler2D linear;
uniform sampler2D normals;
uniform vec2 origin;
uniform float share;
uniform float exposure;
out vec4 colour;
${SRGB}
void main() {
  ivec2 at = ivec2((gl_FragCoord.xy - origin) * share);
  float coverage = texelFetch(normals, at, 0).w;
  colour = vec4(encode(texelFetch(linear, at, 0).rgb * exposure) * coverage, coverage);
}`;

// Sharma, Wu, Dalal 2005; CIELAB under D65 with the matrix of brdfit.metrics.ciede2000.
const CIEDE2000 = `
vec3 lab(vec3 c) {
  c = clamp(c, 0.0, 1.0);
  vec3 xyz = vec3(dot(c, vec3(0.4124, 0.3576, 0.1805)), dot(c, vec3(0.2126, 0.7152, 0.0722)),
                  dot(c, vec3(0.0193, 0.1192, 0.9505))) / vec3(0.9505, 1.0, 1.089);
  vec3 f = mix(xyz * (24389.0 / 27.0 / 116.0) + 16.0 / 116.0, pow(xyz, vec3(1.0 / 3.0)),
               step(216.0 / 24389.0, xyz));
  return vec3(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z));
}
float hue(float b, float a) {
  return a == 0.0 && b == 0.0 ? 0.0 : mod(degrees(atan(b, a)) + 360.0, 360.0);
}
float power7(float c) { return c * c * c * c * c * c * c; }
float ciede2000(vec3 one, vec3 two) {
  float mean = 0.5 * (length(one.yz) + length(two.yz));
  float p7 = power7(mean);
  float g = 0.5 * (1.0 - sqrt(p7 / (p7 + 6103515625.0)));
  vec2 a = vec2(one.y, two.y) * (1.0 + g);
  vec2 c = sqrt(a * a + vec2(one.z * one.z, two.z * two.z));
  vec2 h = vec2(hue(one.z, a.x), hue(two.z, a.y));
  bool grey = c.x * c.y == 0.0;
  float dh = grey ? 0.0 : h.y - h.x;
  if (dh > 180.0) dh -= 360.0;
  if (dh < -180.0) dh += 360.0;
  float dL = two.x - one.x;
  float dC = c.y - c.x;
  float dH = 2.0 * sqrt(c.x * c.y) * sin(radians(0.5 * dh));
  float L = 0.5 * (one.x + two.x);
  float C = 0.5 * (c.x + c.y);
  float H = h.x + h.y;
  if (!grey) {
    if (abs(h.x - h.y) > 180.0) H += H < 360.0 ? 360.0 : -360.0;
    H *= 0.5;
  }
  float T = 1.0 - 0.17 * cos(radians(H - 30.0)) + 0.24 * cos(radians(2.0 * H))
    + 0.32 * cos(radians(3.0 * H + 6.0)) - 0.20 * cos(radians(4.0 * H - 63.0));
  float q = (H - 275.0) / 25.0;
  float turn = 30.0 * exp(-q * q);
  float C7 = power7(C);
  float rC = 2.0 * sqrt(C7 / (C7 + 6103515625.0));
  float l2 = (L - 50.0) * (L - 50.0);
  float sL = 1.0 + 0.015 * l2 / sqrt(20.0 + l2);
  float sC = 1.0 + 0.045 * C;
  float sH = 1.0 + 0.015 * C * T;
  float rT = -sin(radians(2.0 * turn)) * rC;
  vec3 d = vec3(dL / sL, dC / sC, dH / sH);
  return sqrt(max(0.0, dot(d, d) + rT * d.y * d.z));
}`;

/** Delta E00 of two linear images under one exposure, into the red channel. */
export const DIFFERENCE = `#version 300 es
precision highp float;
uniform sampler2D one;
uniform sampler2D two;
uniform sampler2D normals;
uniform float exposure;
out vec4 colour;
${CIEDE2000}
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec3 a = lab(texelFetch(one, at, 0).rgb * exposure);
  vec3 b = lab(texelFetch(two, at, 0).rgb * exposure);
  colour = vec4(ciede2000(a, b), 0.0, 0.0, texelFetch(normals, at, 0).w);
}`;

/** Delta E00 as a colour: 0 dark blue, \`most\` yellow (a fit to viridis). */
export const SHOW_DIFFERENCE = `#version 300 es
precision highp float;
uniform sampler2D difference;
uniform vec2 origin;
uniform float share;
uniform float most;
out vec4 colour;
vec3 ramp(float t) {
  vec3 a = vec3(0.267, 0.005, 0.329), b = vec3(0.230, 0.322, 0.546), c = vec3(0.128, 0.567, 0.551);
  vec3 d = vec3(0.369, 0.789, 0.383), e = vec3(0.993, 0.906, 0.144);
  t *= 4.0;
  if (t < 1.0) return mix(a, b, t);
  if (t < 2.0) return mix(b, c, t - 1.0);
  if (t < 3.0) return mix(c, d, t - 2.0);
  return mix(d, e, t - 3.0);
}
void main() {
  ivec2 at = ivec2((gl_FragCoord.xy - origin) * share);
  vec4 found = texelFetch(difference, at, 0);
  colour = vec4(ramp(clamp(found.r / most, 0.0, 1.0)) * found.a, found.a);
}`;
