// The one pair of shaders, compiled plain (Gouraud), with FLAT, with DISCS and with DISCS and QUADS, each also with
// FADING, there with SAMPLES where the driver can tell them apart; private to this folder. What a material does not
// have costs no triangle of it anything: COLORS of vertices, BASE_COLOR_IMAGE and EMISSIVE_IMAGE (each with
// TEXTURED), MASKED by a cutoff.
//
// A disc is a square sprite around its centre: a point or, where drivers allow none so large, four corners. A fragment
// is kept where the ray from the eye through it meets the disc's plane within its radius: with the centre c and the
// fragment's place c + e in view axes, |n x (e x c)| <= r |n . (c + e)|. That is a quadratic form in the place on the
// sprite, whose coefficients the vertex stage works out. So discs smaller than a pixel cover just what surfaces of
// their size would, and edge-on ones nothing.
#pragma once

#include "client/render/renderer.h"

namespace lodestream::render {

#define SHADER_300 "#version 300 es\n"
#define SHADER_320 "#version 320 es\n"
inline constexpr const char* shader_limits = "#define MAX_LIGHTS 64\n#define DITHER_STEPS 64\n";
static_assert(max_lights == 64);
inline constexpr int dither_steps = 64;  // of a pixel's threshold, or of each of its samples'

// gl_Position is invariant, so Gouraud and flat primitives that share a border cover it without cracks.
inline constexpr const char* vertex_shader = R"(
precision highp float;
layout(location = 0) in vec3 a_position;
#if defined(COLORS) || defined(DISCS)
layout(location = 1) in vec4 a_color;
uniform vec4 u_base_color;
#endif
#ifdef DISCS
layout(location = 3) in vec3 a_normal;  // of unit length; zero: faces the eye
flat out vec3 v_color;   // lit
flat out vec3 v_square;  // of x², xy, y² of the place on the sprite, each in [-1, 1]
flat out vec3 v_linear;  // of x, y, 1; the disc is where the sum is not above zero
uniform mat3 u_view_from_scene;  // axes to the right, up and backwards
uniform vec3 u_picture;          // half its width and height, a unit at depth 1; px
uniform vec3 u_disc;             // radius, px to widen a sprite by, largest sprite in px
#ifdef QUADS
out vec2 v_at;  // the place on the sprite
#endif
#else
#ifdef TEXTURED
layout(location = 2) in vec2 a_texture_coordinate;
out vec2 v_texture_coordinate;
#endif
#ifdef COLORS
out vec4 v_color;
#endif
#ifdef FLAT
layout(location = 3) in vec3 a_previous_corner;
layout(location = 4) in vec3 a_first_corner;
flat out vec2 v_light;  // diffuse, specular
#else
layout(location = 3) in vec3 a_normal;
out vec4 v_light;  // diffuse, specular; the same of the back
#endif
#endif
uniform mat4 u_clip_from_scene;
uniform vec3 u_offset;  // of the instance
uniform vec3 u_eye;
uniform vec4 u_lights[MAX_LIGHTS];  // direction towards the light, intensity
uniform int u_light_count;
uniform vec4 u_phong;  // ambient, diffuse, specular, shininess
invariant gl_Position;

vec3 unit_or_zero(vec3 v) {
    float largest = max(max(abs(v.x), abs(v.y)), abs(v.z));
    return largest > 0.0 ? normalize(v / largest) : vec3(0.0);
}

// The reflection is the same for a normal and its opposite, so a back side costs no second evaluation.
vec4 light_both_sides(vec3 normal, vec3 position) {
    vec3 to_eye = unit_or_zero(u_eye - position);
    vec4 sum = vec4(u_phong.x, 0.0, u_phong.x, 0.0);
    for (int i = 0; i < u_light_count; ++i) {
        vec3 to_light = u_lights[i].xyz;
        float lambert = dot(normal, to_light);
        float highlight = max(dot(2.0 * lambert * normal - to_light, to_eye), 0.0);
        float specular = highlight > 0.0 ? u_phong.z * pow(highlight, u_phong.w) : 0.0;
        sum += u_lights[i].w * vec4(u_phong.y * max(lambert, 0.0), lambert > 0.0 ? specular : 0.0,
                                    u_phong.y * max(-lambert, 0.0), lambert < 0.0 ? specular : 0.0);
    }
    return sum;
}

#ifdef DISCS
// How much larger perspective draws a sphere around the disc off the view's axis and close to the eye, outwards: with t
// the angle between axis and centre and p half the angle that the sphere fills, 1 / cos(t + p).
float stretch(float radius, vec3 center, float depth) {
    const float least_cosine = 1e-3;  // the sphere reaches beside or behind the eye: nothing bounds its picture
    float away = max(dot(center, center), 1e-30), off_axis = max(away - depth * depth, 0.0);
    float cosine = depth * sqrt(max(away - radius * radius, 0.0)) - radius * sqrt(off_axis);
    return away / max(cosine, least_cosine * away);
}

void shape_disc(vec3 position, vec3 normal) {
    const float least_px = 1e-4;
    float depth = max(gl_Position.w, 1e-6), px_per_unit = u_picture.z / depth;
    float radius = max(u_disc.x, least_px / px_per_unit);
    vec3 center = u_view_from_scene * (position - u_eye);
    float side = clamp(2.0 * radius * px_per_unit * stretch(radius, center, depth), 1.0, u_disc.z) + u_disc.y;
#ifdef QUADS
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    gl_Position.xy += corner * (0.5 * side / u_picture.xy) * gl_Position.w;
    v_at = vec2(corner.x, -corner.y);
#else
    gl_PointSize = side;
#endif
    float reach = 0.5 * side / (radius * px_per_unit);  // half the sprite's side, in radii
    float nearness = radius / max(length(center), 1e-6 * radius);
    vec3 c = center * (nearness / radius), n = u_view_from_scene * normal;
    vec3 x = cross(n, cross(vec3(reach, 0.0, 0.0), c)), y = cross(n, cross(vec3(0.0, -reach, 0.0), c));
    vec2 tilt = vec2(reach * n.x, -reach * n.y) * nearness;
    float facing = dot(n, c);
    v_square = vec3(dot(x, x) - tilt.x * tilt.x, 2.0 * (dot(x, y) - tilt.x * tilt.y), dot(y, y) - tilt.y * tilt.y);
    v_linear = vec3(-2.0 * facing * tilt, -facing * facing);
}
#endif

void main() {
    vec3 position = a_position + u_offset;
    gl_Position = u_clip_from_scene * vec4(position, 1.0);
#ifdef DISCS
    vec3 to_eye = unit_or_zero(u_eye - position);
    vec3 normal = a_normal == vec3(0.0) ? to_eye : dot(a_normal, to_eye) < 0.0 ? -a_normal : a_normal;
    vec2 light = light_both_sides(normal, position).xy;
    v_color = u_base_color.rgb * a_color.rgb * light.x + light.y;
    shape_disc(position, normal);
#else
#ifdef COLORS
    v_color = u_base_color * a_color;
#endif
#ifdef TEXTURED
    v_texture_coordinate = a_texture_coordinate;
#endif
#ifdef FLAT
    vec3 center = (a_first_corner + a_previous_corner + a_position) / 3.0 + u_offset;
    vec3 normal = unit_or_zero(cross(a_previous_corner - a_first_corner, a_position - a_first_corner));
    vec4 light = light_both_sides(normal, center);
    v_light = dot(normal, u_eye - center) >= 0.0 ? light.xy : light.zw;
#else
    v_light = light_both_sides(unit_or_zero(a_normal), position);
#endif
#endif
}
)";

inline constexpr const char* fragment_shader = R"(
precision highp float;
precision highp int;
#ifdef DISCS
flat in vec3 v_color;
flat in vec3 v_square;
flat in vec3 v_linear;
#ifdef QUADS
in vec2 v_at;
#endif
#else
#ifdef FLAT
flat in vec2 v_light;
#else
in vec4 v_light;
#endif
#ifdef COLORS
in vec4 v_color;
#else
uniform vec4 u_base_color;
#endif
#ifdef TEXTURED
in vec2 v_texture_coordinate;
#endif
#ifdef BASE_COLOR_IMAGE
uniform sampler2D u_base_color_texture;
#endif
#ifdef EMISSIVE_IMAGE
uniform sampler2D u_emissive_texture;
#endif
uniform vec3 u_emissive;
#ifdef MASKED
uniform float u_alpha_cutoff;
#endif
#endif
out vec4 color;

#ifdef FADING
uniform ivec3 u_share;  // thresholds from and to, and samples a pixel

// Bayer's matrix of 8 by 8 (1973): neighbours are as far apart as can be, and each square of 2, 4 or 8 has all steps.
int dither(ivec2 at) {
    int step = 0;
    for (int i = 0; i < 3; ++i) step = step << 2 | ((at.x ^ at.y) >> i & 1) << 1 | (at.y >> i & 1);
    return step;
}

// Bits of the samples whose thresholds are in the share. A pixel's samples are evenly apart, each first in turn.
int samples_in_share() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    int threshold = dither(at), samples = 0;
    for (int i = 0; i < u_share.z; ++i) {
        int whole = (i + at.x + 2 * at.y) % u_share.z * DITHER_STEPS + threshold;
        if (whole >= u_share.x && whole < u_share.y) samples |= 1 << i;
    }
    return samples;
}
#endif

void main() {
#ifdef FADING
    int samples = samples_in_share();
    if (samples == 0) discard;
#ifdef SAMPLES
    gl_SampleMask[0] = samples;
#endif
#endif
#ifdef DISCS
#ifdef QUADS
    vec2 at = v_at;
#else
    vec2 at = 2.0 * gl_PointCoord - 1.0;
#endif
    if (dot(v_square, vec3(at.x * at, at.y * at.y)) + dot(v_linear, vec3(at, 1.0)) > 0.0) discard;
    color = vec4(v_color, 1.0);
#else
#ifdef FLAT
    vec2 light = v_light;
#else
    vec2 light = gl_FrontFacing ? v_light.xy : v_light.zw;
#endif
#ifdef COLORS
    vec4 base = v_color;
#else
    vec4 base = u_base_color;
#endif
#ifdef BASE_COLOR_IMAGE
    base *= texture(u_base_color_texture, v_texture_coordinate);
#endif
#ifdef MASKED
    if (base.a < u_alpha_cutoff) discard;
#endif
    vec3 emitted = u_emissive;
#ifdef EMISSIVE_IMAGE
    emitted *= texture(u_emissive_texture, v_texture_coordinate).rgb;
#endif
    color = vec4(base.rgb * light.x + light.y + emitted, base.a);
#endif
}
)";

}  // namespace lodestream::render
