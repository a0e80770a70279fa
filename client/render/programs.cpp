#include "client/render/programs.h"

#include <array>
#include <string>
#include <utility>

#include "client/render/shaders.h"

namespace lodestream::render {
namespace {

Result<GLuint> compile(GLenum stage, const char* head, const char* source) {
    const GLuint shader = glCreateShader(stage);
    const std::array<const char*, 3> parts{head, shader_limits, source};
    glShaderSource(shader, static_cast<GLsizei>(parts.size()), parts.data(), nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (compiled) return shader;
    std::array<char, 512> log{};
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteShader(shader);
    return fail(ErrorCode::internal, std::string("shader: ") + log.data());
}

Result<Program> program_of(const std::string& head) {
    const auto linked = link(head, vertex_shader, fragment_shader);
    if (!linked) return linked.error();
    Program program;
    program.id = *linked;
    const auto uniform = [&](const char* name) { return glGetUniformLocation(program.id, name); };
    program.clip_from_scene = uniform("u_clip_from_scene");
    program.view_from_scene = uniform("u_view_from_scene");
    program.picture = uniform("u_picture");
    program.offset = uniform("u_offset");
    program.eye = uniform("u_eye");
    program.lights = uniform("u_lights");
    program.light_count = uniform("u_light_count");
    program.phong = uniform("u_phong");
    program.base_color = uniform("u_base_color");
    program.emissive = uniform("u_emissive");
    program.alpha_cutoff = uniform("u_alpha_cutoff");
    program.disc = uniform("u_disc");
    program.share = uniform("u_share");
    glUseProgram(program.id);
    for (const auto& [name, unit] : {std::pair{"u_base_color_texture", 0}, {"u_emissive_texture", 1}})
        if (const GLint location = uniform(name); location >= 0) glUniform1i(location, unit);
    glUseProgram(0);  // one in use outlives its deletion
    return program;
}

std::string definitions(Style style, const Look& look) {
    constexpr std::array<const char*, 4> of_styles{"", "#define FLAT\n", "#define DISCS\n",
                                                   "#define DISCS\n#define QUADS\n"};
    std::string text = of_styles[static_cast<std::size_t>(style)];
    if (look.has_colors) text += "#define COLORS\n";
    if (look.has_base_color_image) text += "#define BASE_COLOR_IMAGE\n";
    if (look.has_emissive_image) text += "#define EMISSIVE_IMAGE\n";
    if (look.is_textured()) text += "#define TEXTURED\n";
    if (look.is_masked) text += "#define MASKED\n";
    return text;
}

std::uint32_t key_of(Style style, const Look& look) {
    std::uint32_t key = static_cast<std::uint32_t>(style);
    for (const bool has : {look.has_colors, look.has_base_color_image, look.has_emissive_image, look.is_masked})
        key = key << 1 | (has ? 1u : 0u);
    return key;
}

}  // namespace

Result<GLuint> link(const std::string& head, const char* vertex_source, const char* fragment_source) {
    const auto vertex = compile(GL_VERTEX_SHADER, head.c_str(), vertex_source);
    if (!vertex) return vertex.error();
    const auto fragment = compile(GL_FRAGMENT_SHADER, head.c_str(), fragment_source);
    if (!fragment) {
        glDeleteShader(*vertex);
        return fragment.error();
    }
    const GLuint program = glCreateProgram();
    glAttachShader(program, *vertex);
    glAttachShader(program, *fragment);
    glLinkProgram(program);
    glDeleteShader(*vertex);
    glDeleteShader(*fragment);
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked) return program;
    glDeleteProgram(program);
    return fail(ErrorCode::internal, "shader program does not link");
}

Programs::~Programs() {
    for_each([](const Program& program) { glDeleteProgram(program.id); });
}

Status Programs::link(Style style, const Look& look) {
    const std::uint32_t key = key_of(style, look);
    if (pairs_.contains(key)) return Nothing{};
    const std::string defined = definitions(style, look);
    const auto whole = program_of(SHADER_300 + defined);
    if (!whole) return whole.error();
    const std::string fading_head =
        driver_version() >= 32 ? SHADER_320 "#define FADING\n#define SAMPLES\n" : SHADER_300 "#define FADING\n";
    const auto fading = program_of(fading_head + defined);
    if (!fading) {
        glDeleteProgram(whole->id);
        return fading.error();
    }
    pairs_[key] = {*whole, *fading};
    return Nothing{};
}

const Program& Programs::at(Style style, const Look& look, bool fades) const {
    const Pair& pair = pairs_.at(key_of(style, look));
    return fades ? pair.fading : pair.whole;
}

void Programs::for_each(const std::function<void(const Program&)>& take) const {
    for (const auto& [key, pair] : pairs_) {
        take(pair.whole);
        take(pair.fading);
    }
}

}  // namespace lodestream::render
