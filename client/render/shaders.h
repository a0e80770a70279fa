// The one pair of shaders, compiled with and without FLAT; private to this folder.
#pragma once

#include "client/render/renderer.h"

namespace lodestream::render {

inline constexpr const char* shader_version = "#version 300 es\n#define MAX_LIGHTS 64\n";
static_assert(max_lights == 64);

// gl_Position is invariant, so Gouraud and flat primitives that share a border cover it without cracks.
inline constexpr const char* vertex_shader = R"(
precision highp float;
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_color;
layout(location = 2) in vec2 a_texture_coordinate;
#ifdef FLAT
layout(location = 3) in vec3 a_previous_corner;
layout(location = 4) in vec3 a_first_corner;
flat out vec2 v_light;  // diffuse, specular
#else
layout(location = 3) in vec3 a_normal;
out vec4 v_light;  // diffuse, specular; the same of the back
#endif
out vec4 v_color;
out vec2 v_texture_coordinate;
uniform mat4 u_clip_from_scene;
uniform vec3 u_eye;
uniform vec4 u_lights[MAX_LIGHTS];  // direction towards the light, intensity
uniform int u_light_count;
uniform vec4 u_phong;  // ambient, diffuse, specular, shininess
uniform vec4 u_base_color;
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

void main() {
    gl_Position = u_clip_from_scene * vec4(a_position, 1.0);
    v_color = u_base_color * a_color;
    v_texture_coordinate = a_texture_coordinate;
#ifdef FLAT
    vec3 center = (a_first_corner + a_previous_corner + a_position) / 3.0;
    vec3 normal = unit_or_zero(cross(a_previous_corner - a_first_corner, a_position - a_first_corner));
    vec4 light = light_both_sides(normal, center);
    v_light = dot(normal, u_eye - center) >= 0.0 ? light.xy : light.zw;
#else
    v_light = light_both_sides(unit_or_zero(a_normal), a_position);
#endif
}
)";

inline constexpr const char* fragment_shader = R"(
precision highp float;
#ifdef FLAT
flat in vec2 v_light;
#else
in vec4 v_light;
#endif
in vec4 v_color;
in vec2 v_texture_coordinate;
uniform sampler2D u_base_color_texture;
uniform sampler2D u_emissive_texture;
uniform vec3 u_emissive;
uniform float u_alpha_cutoff;
out vec4 color;

void main() {
#ifdef FLAT
    vec2 light = v_light;
#else
    vec2 light = gl_FrontFacing ? v_light.xy : v_light.zw;
#endif
    vec4 base = v_color * texture(u_base_color_texture, v_texture_coordinate);
    if (base.a < u_alpha_cutoff) discard;
    vec3 emitted = u_emissive * texture(u_emissive_texture, v_texture_coordinate).rgb;
    color = vec4(base.rgb * light.x + light.y + emitted, base.a);
}
)";

}  // namespace lodestream::render
