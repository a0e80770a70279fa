#include "tests/client/render/fake/recording_gl.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>

#include "tests/client/render/fake/glsl_interface.h"

namespace lodestream::testing {
namespace {

constexpr std::size_t max_attributes = 16, texture_units = 2;
constexpr GLuint name_stride = 8;  // contexts whose objects have names apart
GLuint contexts_made = 0;

struct Buffer {
    std::vector<std::byte> bytes;
};

struct Texture {
    GLsizei width = 0, height = 0;
    bool has_mips = false, needs_mips = true;  // what OpenGL starts with
    std::uint64_t bytes = 0;
};

struct Renderbuffer {
    GLenum format = 0;
    GLsizei width = 0, height = 0, samples = 0;
    std::uint64_t bytes = 0;
    std::array<std::uint8_t, 4> color{};  // that it was cleared with, as read back
};

struct Framebuffer {
    GLuint color = 0, depth = 0;
};

struct Attribute {
    bool is_enabled = false;
    GLint components = 4;
    GLenum type = GL_FLOAT;
    bool is_normalized = false;
    GLsizei stride = 0;
    std::size_t offset = 0;
    GLuint buffer = 0, divisor = 0;
};

struct VertexArray {
    std::array<Attribute, max_attributes> attributes;
    GLuint elements = 0;
};

struct Shader {
    GLenum stage = 0;
    std::string source;
    std::optional<GlslInterface> interface;  // where it compiled
    std::string log;
};

struct Uniform {
    std::string name;
    GlslVariable variable;
    std::vector<float> values;
    bool is_set = false;
};

struct Program {
    std::vector<GlslInterface> stages;  // of the attached shaders, vertex first
    bool is_linked = false;
    bool goes_when_unused = false;  // deleted while in use
    std::map<std::string, GlslVariable> ins;
    std::vector<Uniform> uniforms;  // a location each
};

// What leaves the vertex stage is what the fragment stage takes.
bool fit(const GlslInterface& vertex, const GlslInterface& fragment) {
    return std::all_of(fragment.ins.begin(), fragment.ins.end(), [&](const auto& in) {
        const auto out = vertex.outs.find(in.first);
        return out != vertex.outs.end() && out->second == in.second;
    });
}

std::uint8_t to_srgb8(float linear) {
    const double x = std::clamp(static_cast<double>(linear), 0.0, 1.0);
    return static_cast<std::uint8_t>(
        std::lround(255.0 * (x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055)));
}

std::size_t size_of(GLenum type) {
    return type == GL_UNSIGNED_BYTE ? 1 : 4;
}

}  // namespace

// All that a context holds.
class GlState {
  public:
    explicit GlState(const GlDriver& what) : driver(what) {}

    GlDriver driver;
    GlRecord record;

    std::map<GLuint, Buffer> buffers;
    std::map<GLuint, Texture> textures;
    std::map<GLuint, Renderbuffer> renderbuffers;
    std::map<GLuint, Framebuffer> framebuffers;
    std::map<GLuint, VertexArray> vertex_arrays;
    std::map<GLuint, Shader> shaders;
    std::map<GLuint, Program> programs;
    std::set<GLuint> deleted;

    GLuint program = 0, vertex_array = 0, array_buffer = 0, renderbuffer = 0, read_framebuffer = 0,
           draw_framebuffer = 0;
    std::size_t unit = 0;
    std::array<GLuint, texture_units> bound_textures{};
    std::array<Vec4f, max_attributes> constants;  // of attributes that are not enabled
    std::set<GLenum> enabled;
    bool writes_depth = true;
    GLenum depth_function = GL_LESS;
    GLbitfield sample_mask = ~0u;
    Vec4f clear_color{0.0f};
    std::array<GLsizei, 4> viewport{};
    GLint pack_alignment = 4;
    GLenum error = GL_NO_ERROR;

    void misuse(const std::string& what) {
        if (std::find(record.misuses.begin(), record.misuses.end(), what) == record.misuses.end())
            record.misuses.push_back(what);
    }
    // An error that OpenGL itself reports; the renderer is to cause none but of memory.
    void wrong(GLenum code, const std::string& what) {
        fail(code);
        misuse(what);
    }
    void fail(GLenum code) {
        if (error == GL_NO_ERROR) error = code;
    }

    template <class Object>
    GLuint create(std::map<GLuint, Object>& objects) {
        const GLuint name = next_name_;
        next_name_ += name_stride;
        objects.emplace(name, Object{});
        ++record.created;
        return name;
    }

    template <class Object>
    void create(std::map<GLuint, Object>& objects, GLsizei count, GLuint* names) {
        for (GLsizei i = 0; i < count; ++i) names[i] = create(objects);
    }

    template <class Object>
    void erase(std::map<GLuint, Object>& objects, GLuint name, const std::string& kind) {
        if (name == 0) return;
        if (objects.erase(name) == 0)
            return misuse(kind + (deleted.contains(name) ? " deleted twice" : " deleted that this context never had"));
        deleted.insert(name);
        ++record.deleted;
    }

    // The object, or null after naming what is wrong.
    template <class Object>
    Object* find(std::map<GLuint, Object>& objects, GLuint name, const std::string& kind) {
        const auto found = objects.find(name);
        if (found != objects.end()) return &found->second;
        const std::string why = name == 0                ? "none is bound"
                                : deleted.contains(name) ? "it is deleted"
                                                         : "this context never had it";
        wrong(GL_INVALID_OPERATION, kind + ": " + why);
        return nullptr;
    }

    template <class Object>
    void bind(std::map<GLuint, Object>& objects, GLuint name, GLuint& binding, const std::string& kind) {
        if (name == 0 || find(objects, name, "a bound " + kind)) binding = name;
    }

    // False where the driver has no memory for it: what it held before is gone, as OpenGL has it.
    bool take_memory(std::uint64_t& held, std::uint64_t bytes) {
        record.bytes -= std::exchange(held, 0);
        if (record.bytes + bytes > driver.memory_bytes) {
            fail(GL_OUT_OF_MEMORY);
            return false;
        }
        record.bytes += held = bytes;
        record.peak_bytes = std::max(record.peak_bytes, record.bytes);
        return true;
    }

    GLenum status_of(GLuint name) {
        const Framebuffer* framebuffer = find(framebuffers, name, "a framebuffer");
        if (!framebuffer || !driver.completes_framebuffers) return GL_FRAMEBUFFER_UNSUPPORTED;
        const auto color = renderbuffers.find(framebuffer->color), depth = renderbuffers.find(framebuffer->depth);
        if (color == renderbuffers.end()) return GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT;
        const auto is_stored = [](const Renderbuffer& r) { return r.bytes > 0; };
        if (!is_stored(color->second)) return GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT;
        if (depth == renderbuffers.end()) return GL_FRAMEBUFFER_COMPLETE;
        if (!is_stored(depth->second)) return GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT;
        return color->second.samples == depth->second.samples ? GL_FRAMEBUFFER_COMPLETE
                                                              : GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE;
    }

    // The colours of a complete framebuffer, or null after naming what is wrong.
    Renderbuffer* colors_of(GLuint name, const std::string& what) {
        if (status_of(name) == GL_FRAMEBUFFER_COMPLETE) return &renderbuffers.at(framebuffers.at(name).color);
        wrong(GL_INVALID_FRAMEBUFFER_OPERATION, what + " a framebuffer that is not complete");
        return nullptr;
    }

    Uniform* uniform_at(GLint location) {
        Program* used = find(programs, program, "the program of a uniform");
        if (!used) return nullptr;
        if (location >= 0 && static_cast<std::size_t>(location) < used->uniforms.size())
            return &used->uniforms[static_cast<std::size_t>(location)];
        misuse("a uniform that the program does not have is set");
        return nullptr;
    }

    void set_uniform(GLint location, std::initializer_list<std::string_view> types, std::span<const float> values) {
        Uniform* uniform = uniform_at(location);
        if (!uniform) return;
        const std::string& type = uniform->variable.type;
        if (std::find(types.begin(), types.end(), type) == types.end())
            return wrong(GL_INVALID_OPERATION, uniform->name + " is set as another type than " + type);
        if (values.size() > components_of(type) * uniform->variable.elements)
            return wrong(GL_INVALID_OPERATION, uniform->name + " is set beyond its end");
        for (const float value : values)
            if (!std::isfinite(value)) misuse(uniform->name + " is not finite");
        uniform->values.assign(values.begin(), values.end());
        uniform->is_set = true;
    }

    // What the shader reads of an attribute; zero after naming what is wrong.
    Vec4f read(const std::string& name, const Attribute& attribute, std::size_t vertex) {
        const auto buffer = buffers.find(attribute.buffer);
        if (buffer == buffers.end()) {
            misuse(name + " is read from a buffer that is deleted or was never there");
            return Vec4f{0.0f};
        }
        const auto components = static_cast<std::size_t>(attribute.components);
        const std::size_t one = size_of(attribute.type), packed = components * one;
        const std::size_t stride = attribute.stride > 0 ? static_cast<std::size_t>(attribute.stride) : packed;
        const std::size_t at = attribute.offset + vertex * stride;
        if (at + packed > buffer->second.bytes.size()) {
            misuse(name + " is read beyond its buffer");
            return Vec4f{0.0f};
        }
        Vec4f value{0.0f, 0.0f, 0.0f, 1.0f};
        for (std::size_t c = 0; c < components; ++c) {
            const std::byte* from = &buffer->second.bytes[at + c * one];
            float& to = value[static_cast<int>(c)];
            if (attribute.type == GL_FLOAT)
                std::memcpy(&to, from, sizeof to);
            else
                to = static_cast<float>(*from) / (attribute.is_normalized ? 255.0f : 1.0f);
            if (!std::isfinite(to)) misuse(name + " is not finite");
        }
        return value;
    }

    void read_attributes(GlDraw& draw, const Program& used, const VertexArray& array,
                         const std::vector<std::uint32_t>& vertices) {
        for (const auto& [name, in] : used.ins) {
            const auto location = static_cast<std::size_t>(in.location);
            const Attribute& attribute = array.attributes[location];
            std::vector<Vec4f>& values = draw.vertices[name];
            if (!attribute.is_enabled) {
                values.push_back(constants[location]);
            } else if (attribute.divisor > 0) {
                for (std::size_t i = 0; i < static_cast<std::size_t>(draw.instances); ++i)
                    values.push_back(read(name, attribute, i / attribute.divisor));
            } else {
                for (const std::uint32_t vertex : vertices) values.push_back(read(name, attribute, vertex));
            }
        }
        for (std::size_t i = 0; i < max_attributes; ++i)
            if (array.attributes[i].is_enabled && std::none_of(used.ins.begin(), used.ins.end(), [&](const auto& in) {
                    return in.second.location == static_cast<int>(i);
                }))
                misuse("an attribute is enabled that the program does not read");
    }

    void check_textures(const Program& used, GlDraw& draw) {
        for (const Uniform& uniform : used.uniforms) {
            if (uniform.variable.type != "sampler2D" || !uniform.is_set) continue;
            const auto at = static_cast<std::size_t>(uniform.values[0]);
            const Texture* texture = find(textures, bound_textures[at], "the texture of " + uniform.name);
            if (texture && (texture->bytes == 0 || (texture->needs_mips && !texture->has_mips)))
                misuse(uniform.name + " reads a texture that is not complete");
        }
        draw.textures = bound_textures;
    }

    void draw(GLenum mode, GLsizei instances, const std::vector<std::uint32_t>& vertices) {
        const Program* used = find(programs, program, "the program of a drawing");
        const VertexArray* array = find(vertex_arrays, vertex_array, "the vertex array of a drawing");
        const Renderbuffer* colors = colors_of(draw_framebuffer, "drawing to");
        if (!used || !array || !colors) return;
        if (viewport != std::array<GLsizei, 4>{0, 0, colors->width, colors->height})
            misuse("the viewport is not the picture's");
        GlDraw draw{mode, static_cast<GLsizei>(vertices.size()), instances, {}, {}, {}};
        for (const Uniform& uniform : used->uniforms) {
            if (!uniform.is_set) misuse(uniform.name + " was never set");
            draw.uniforms[uniform.name] = uniform.values;
        }
        read_attributes(draw, *used, *array, vertices);
        check_textures(*used, draw);
        draw.blends = enabled.contains(GL_BLEND);
        draw.writes_depth = writes_depth;
        draw.tests_depth = enabled.contains(GL_DEPTH_TEST) && depth_function == GL_LEQUAL;
        draw.shades_samples = enabled.contains(GL_SAMPLE_SHADING);
        if (enabled.contains(GL_SAMPLE_MASK)) draw.samples = sample_mask;
        record.draws.push_back(std::move(draw));
    }

  private:
    GLuint next_name_ = 1 + contexts_made++ % name_stride;
};

namespace {

GlState* current = nullptr;

// Where no context is current, calls do nothing that anyone sees.
GlState& now() {
    static GlState nowhere{GlDriver{}};
    return current ? *current : nowhere;
}

Attribute* attribute_at(GLuint index) {
    GlState& gl = now();
    if (index >= max_attributes) {
        gl.wrong(GL_INVALID_VALUE, "an attribute that no driver has");
        return nullptr;
    }
    VertexArray* array = gl.find(gl.vertex_arrays, gl.vertex_array, "the vertex array of an attribute");
    return array ? &array->attributes[index] : nullptr;
}

GLuint* buffer_binding(GLenum target) {
    GlState& gl = now();
    if (target == GL_ARRAY_BUFFER) return &gl.array_buffer;
    if (target != GL_ELEMENT_ARRAY_BUFFER) {
        gl.wrong(GL_INVALID_ENUM, "a buffer target that the fake does not know");
        return nullptr;
    }
    VertexArray* array = gl.find(gl.vertex_arrays, gl.vertex_array, "the vertex array of indices");
    return array ? &array->elements : nullptr;
}

Texture* bound_texture() {
    GlState& gl = now();
    return gl.find(gl.textures, gl.bound_textures[gl.unit], "the texture of a call");
}

// OpenGL ES 3.0 knows neither.
void check_capability(GLenum capability) {
    GlState& gl = now();
    if ((capability == GL_SAMPLE_MASK && gl.driver.version < 31) ||
        (capability == GL_SAMPLE_SHADING && gl.driver.version < 32))
        gl.wrong(GL_INVALID_ENUM, "a capability that this version of OpenGL ES does not know");
}

}  // namespace

RecordingGl::RecordingGl(const GlDriver& driver) : state_(std::make_unique<GlState>(driver)) {
    make_current();
}

RecordingGl::~RecordingGl() {
    if (current == state_.get()) current = nullptr;
}

void RecordingGl::make_current() {
    current = state_.get();
}
GlDriver& RecordingGl::driver() {
    return state_->driver;
}
GlRecord& RecordingGl::record() {
    return state_->record;
}

}  // namespace lodestream::testing

// The entry points, by their reserved names.
// NOLINTBEGIN(readability-identifier-naming)
using namespace lodestream::testing;

extern "C" {

const GLubyte* glGetString(GLenum name) {
    if (!current) return nullptr;
    return reinterpret_cast<const GLubyte*>(name == GL_VERSION ? "OpenGL ES 3 recording" : "recording");
}

GLenum glGetError() {
    return std::exchange(now().error, GL_NO_ERROR);
}

void glGetIntegerv(GLenum name, GLint* values) {
    GlState& gl = now();
    const GlDriver& driver = gl.driver;
    const bool is_es3 = driver.version >= 30;
    if (name == GL_MAJOR_VERSION && is_es3)
        *values = driver.version / 10;
    else if (name == GL_MINOR_VERSION && is_es3)
        *values = driver.version % 10;
    else if (name == GL_MAX_SAMPLES && is_es3)
        *values = driver.max_samples;
    else if (name == GL_MAX_RENDERBUFFER_SIZE)
        *values = driver.max_side;
    else if (name == GL_MAX_TEXTURE_SIZE)
        *values = driver.max_texture_side;
    else if (name == GL_MAX_VIEWPORT_DIMS)
        values[0] = values[1] = driver.max_side;
    else
        gl.fail(GL_INVALID_ENUM);
}

void glGetFloatv(GLenum name, GLfloat* values) {
    if (name != GL_ALIASED_POINT_SIZE_RANGE) return now().wrong(GL_INVALID_ENUM, "glGetFloatv of an unknown name");
    values[0] = 1.0f;
    values[1] = now().driver.max_point_px;
}

void glFinish() {}
void glDepthFunc(GLenum function) {
    now().depth_function = function;
}
void glDepthMask(GLboolean writes) {
    now().writes_depth = writes == GL_TRUE;
}
void glBlendFunc(GLenum source, GLenum destination) {
    if (source != GL_SRC_ALPHA || destination != GL_ONE_MINUS_SRC_ALPHA) now().misuse("blending that is not by alpha");
}
void glEnable(GLenum capability) {
    check_capability(capability);
    now().enabled.insert(capability);
}
void glDisable(GLenum capability) {
    check_capability(capability);
    now().enabled.erase(capability);
}
void glMinSampleShading(GLfloat) {
    if (now().driver.version < 32) now().misuse("glMinSampleShading is of OpenGL ES 3.2");
}
void glSampleMaski(GLuint word, GLbitfield mask) {
    if (now().driver.version < 31) now().misuse("glSampleMaski is of OpenGL ES 3.1");
    if (word != 0) now().wrong(GL_INVALID_VALUE, "a word of the sample mask that no driver has");
    if (mask == 0) now().misuse("a sample mask without samples");
    now().sample_mask = mask;
}
void glPixelStorei(GLenum name, GLint value) {
    if (name == GL_PACK_ALIGNMENT) now().pack_alignment = value;
}
void glViewport(GLint x, GLint y, GLsizei width, GLsizei height) {
    now().viewport = {x, y, width, height};
}

// Shaders and programs.

GLuint glCreateShader(GLenum stage) {
    const GLuint name = now().create(now().shaders);
    now().shaders[name].stage = stage;
    return name;
}

void glShaderSource(GLuint name, GLsizei parts, const GLchar* const* texts, const GLint* lengths) {
    Shader* shader = now().find(now().shaders, name, "a shader");
    if (!shader) return;
    if (lengths) return now().misuse("the fake takes sources that end with 0");
    for (GLsizei i = 0; i < parts; ++i) shader->source += texts[i];
}

void glCompileShader(GLuint name) {
    GlState& gl = now();
    Shader* shader = gl.find(gl.shaders, name, "a shader");
    if (!shader) return;
    const std::string& refused = gl.driver.refused_shader;
    const auto read = lodestream::testing::glsl_interface(shader->source);
    if (!read)
        shader->log = read.error().message;
    else if (gl.driver.version < 30 || (!refused.empty() && shader->source.find(refused) != std::string::npos))
        shader->log = "refused";
    else
        shader->interface = *read;
}

void glGetShaderiv(GLuint name, GLenum what, GLint* value) {
    const Shader* shader = now().find(now().shaders, name, "a shader");
    if (shader && what == GL_COMPILE_STATUS) *value = shader->interface ? GL_TRUE : GL_FALSE;
}

void glGetShaderInfoLog(GLuint name, GLsizei size, GLsizei*, GLchar* log) {
    const Shader* shader = now().find(now().shaders, name, "a shader");
    if (shader && size > 0) log[shader->log.copy(log, static_cast<std::size_t>(size) - 1)] = '\0';
}

void glDeleteShader(GLuint name) {
    now().erase(now().shaders, name, "a shader");
}

GLuint glCreateProgram() {
    return now().create(now().programs);
}

void glAttachShader(GLuint name, GLuint shader_name) {
    Program* program = now().find(now().programs, name, "a program");
    const Shader* shader = now().find(now().shaders, shader_name, "a shader");
    if (!program || !shader) return;
    if (!shader->interface) return now().misuse("a shader that did not compile is attached");
    const bool is_vertex = shader->stage == GL_VERTEX_SHADER;
    program->stages.insert(is_vertex ? program->stages.begin() : program->stages.end(), *shader->interface);
}

void glLinkProgram(GLuint name) {
    Program* program = now().find(now().programs, name, "a program");
    if (!program) return;
    program->is_linked =
        now().driver.links && program->stages.size() == 2 && fit(program->stages[0], program->stages[1]);
    if (!program->is_linked) return;
    program->ins = program->stages[0].ins;
    program->uniforms.clear();
    std::map<std::string, GlslVariable> uniforms;
    for (const GlslInterface& stage : program->stages) uniforms.insert(stage.uniforms.begin(), stage.uniforms.end());
    for (const auto& [uniform, variable] : uniforms) program->uniforms.push_back({uniform, variable, {}, false});
}

void glGetProgramiv(GLuint name, GLenum what, GLint* value) {
    const Program* program = now().find(now().programs, name, "a program");
    if (program && what == GL_LINK_STATUS) *value = program->is_linked ? GL_TRUE : GL_FALSE;
}

GLint glGetUniformLocation(GLuint name, const GLchar* uniform) {
    const Program* program = now().find(now().programs, name, "a program");
    if (!program) return -1;
    const auto found = std::find_if(program->uniforms.begin(), program->uniforms.end(),
                                    [&](const Uniform& u) { return u.name == uniform; });
    return found == program->uniforms.end() ? -1 : static_cast<GLint>(found - program->uniforms.begin());
}

void glUseProgram(GLuint name) {
    GlState& gl = now();
    const Program* program = name == 0 ? nullptr : gl.find(gl.programs, name, "a program");
    if (program && !program->is_linked) return gl.wrong(GL_INVALID_OPERATION, "a program in use that is not linked");
    if (!program && name != 0) return;
    const GLuint before = std::exchange(gl.program, name);
    if (const auto found = gl.programs.find(before); found != gl.programs.end() && found->second.goes_when_unused)
        gl.erase(gl.programs, before, "a program");
}

void glDeleteProgram(GLuint name) {
    GlState& gl = now();
    if (gl.program != name || name == 0) return gl.erase(gl.programs, name, "a program");
    gl.programs.at(name).goes_when_unused = true;
}

void glUniform1f(GLint location, GLfloat x) {
    now().set_uniform(location, {"float"}, std::array{x});
}
void glUniform1i(GLint location, GLint x) {
    now().set_uniform(location, {"int", "sampler2D"}, std::array{static_cast<float>(x)});
}
void glUniform3i(GLint location, GLint x, GLint y, GLint z) {
    now().set_uniform(location, {"ivec3"},
                      std::array{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
}
void glUniform3f(GLint location, GLfloat x, GLfloat y, GLfloat z) {
    now().set_uniform(location, {"vec3"}, std::array{x, y, z});
}
void glUniform4f(GLint location, GLfloat x, GLfloat y, GLfloat z, GLfloat w) {
    now().set_uniform(location, {"vec4"}, std::array{x, y, z, w});
}
void glUniform4fv(GLint location, GLsizei count, const GLfloat* values) {
    now().set_uniform(location, {"vec4"}, std::span(values, static_cast<std::size_t>(count) * 4));
}
void glUniformMatrix3fv(GLint location, GLsizei count, GLboolean, const GLfloat* values) {
    now().set_uniform(location, {"mat3"}, std::span(values, static_cast<std::size_t>(count) * 9));
}
void glUniformMatrix4fv(GLint location, GLsizei count, GLboolean, const GLfloat* values) {
    now().set_uniform(location, {"mat4"}, std::span(values, static_cast<std::size_t>(count) * 16));
}

// Buffers and vertex arrays.

void glGenBuffers(GLsizei count, GLuint* names) {
    now().create(now().buffers, count, names);
}

void glBindBuffer(GLenum target, GLuint name) {
    if (GLuint* binding = buffer_binding(target)) now().bind(now().buffers, name, *binding, "buffer");
}

void glBufferData(GLenum target, GLsizeiptr size, const void* data, GLenum) {
    GlState& gl = now();
    const GLuint* binding = buffer_binding(target);
    Buffer* buffer = binding ? gl.find(gl.buffers, *binding, "the buffer to fill") : nullptr;
    if (!buffer) return;
    std::uint64_t held = buffer->bytes.size();
    buffer->bytes.clear();
    if (!gl.take_memory(held, static_cast<std::uint64_t>(size))) return;
    const auto* bytes = static_cast<const std::byte*>(data);
    buffer->bytes.assign(bytes, bytes + size);
    ++gl.record.uploads;
}

void glGetBufferParameteriv(GLenum target, GLenum what, GLint* value) {
    const GLuint* binding = buffer_binding(target);
    const Buffer* buffer = binding ? now().find(now().buffers, *binding, "a buffer to ask") : nullptr;
    if (buffer && what == GL_BUFFER_SIZE) *value = static_cast<GLint>(buffer->bytes.size());
}

void glDeleteBuffers(GLsizei count, const GLuint* names) {
    GlState& gl = now();
    for (GLsizei i = 0; i < count; ++i) {
        if (const auto found = gl.buffers.find(names[i]); found != gl.buffers.end())
            gl.record.bytes -= found->second.bytes.size();
        gl.erase(gl.buffers, names[i], "a buffer");
        if (gl.array_buffer == names[i]) gl.array_buffer = 0;
    }
}

void glGenVertexArrays(GLsizei count, GLuint* names) {
    now().create(now().vertex_arrays, count, names);
}
void glBindVertexArray(GLuint name) {
    now().bind(now().vertex_arrays, name, now().vertex_array, "vertex array");
}
void glDeleteVertexArrays(GLsizei count, const GLuint* names) {
    for (GLsizei i = 0; i < count; ++i) {
        now().erase(now().vertex_arrays, names[i], "a vertex array");
        if (now().vertex_array == names[i]) now().vertex_array = 0;
    }
}

void glEnableVertexAttribArray(GLuint index) {
    if (Attribute* attribute = attribute_at(index)) attribute->is_enabled = true;
}

void glVertexAttribPointer(GLuint index, GLint components, GLenum type, GLboolean normalized, GLsizei stride,
                           const void* offset) {
    Attribute* attribute = attribute_at(index);
    if (!attribute) return;
    if (!now().find(now().buffers, now().array_buffer, "the buffer of an attribute")) return;
    attribute->components = components;
    attribute->type = type;
    attribute->is_normalized = normalized == GL_TRUE;
    attribute->stride = stride;
    attribute->offset = reinterpret_cast<std::size_t>(offset);
    attribute->buffer = now().array_buffer;
    if (attribute->offset % size_of(type) != 0) now().misuse("an attribute that is not aligned to its type");
}

void glVertexAttribDivisor(GLuint index, GLuint divisor) {
    if (Attribute* attribute = attribute_at(index)) attribute->divisor = divisor;
}

void glVertexAttrib3f(GLuint index, GLfloat x, GLfloat y, GLfloat z) {
    now().constants[index] = {x, y, z, 1.0f};
}
void glVertexAttrib4f(GLuint index, GLfloat x, GLfloat y, GLfloat z, GLfloat w) {
    now().constants[index] = {x, y, z, w};
}

// Textures.

void glGenTextures(GLsizei count, GLuint* names) {
    now().create(now().textures, count, names);
}

void glActiveTexture(GLenum unit) {
    if (unit < GL_TEXTURE0 || unit >= GL_TEXTURE0 + texture_units)
        return now().wrong(GL_INVALID_ENUM, "a texture unit that the renderer has no use for");
    now().unit = unit - GL_TEXTURE0;
}

void glBindTexture(GLenum, GLuint name) {
    now().bind(now().textures, name, now().bound_textures[now().unit], "texture");
}

void glTexImage2D(GLenum, GLint, GLint, GLsizei width, GLsizei height, GLint, GLenum, GLenum, const void*) {
    GlState& gl = now();
    Texture* texture = bound_texture();
    if (!texture) return;
    if (width < 1 || height < 1 || std::max(width, height) > gl.driver.max_texture_side)
        return gl.wrong(GL_INVALID_VALUE, "a texture that is larger than the driver allows");
    if (!gl.take_memory(texture->bytes,
                        std::uint64_t{4} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height)))
        return;
    texture->width = width;
    texture->height = height;
    ++gl.record.uploads;
}

void glTexParameteri(GLenum, GLenum name, GLint value) {
    Texture* texture = bound_texture();
    if (texture && name == GL_TEXTURE_MIN_FILTER) texture->needs_mips = value != GL_LINEAR && value != GL_NEAREST;
}

void glGenerateMipmap(GLenum) {
    if (Texture* texture = bound_texture()) texture->has_mips = texture->bytes > 0;
}

void glDeleteTextures(GLsizei count, const GLuint* names) {
    GlState& gl = now();
    for (GLsizei i = 0; i < count; ++i) {
        if (const auto found = gl.textures.find(names[i]); found != gl.textures.end())
            gl.record.bytes -= found->second.bytes;
        gl.erase(gl.textures, names[i], "a texture");
        for (GLuint& bound : gl.bound_textures)
            if (bound == names[i]) bound = 0;
    }
}

// What is drawn into.

void glGenRenderbuffers(GLsizei count, GLuint* names) {
    now().create(now().renderbuffers, count, names);
}
void glBindRenderbuffer(GLenum, GLuint name) {
    now().bind(now().renderbuffers, name, now().renderbuffer, "renderbuffer");
}

void glRenderbufferStorageMultisample(GLenum, GLsizei samples, GLenum format, GLsizei width, GLsizei height) {
    GlState& gl = now();
    Renderbuffer* buffer = gl.find(gl.renderbuffers, gl.renderbuffer, "the renderbuffer to store");
    if (!buffer) return;
    if (std::max(width, height) > gl.driver.max_side || samples > gl.driver.max_samples)
        return gl.wrong(GL_INVALID_VALUE, "a renderbuffer that is larger than the driver allows");
    const auto pixels = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    if (!gl.take_memory(buffer->bytes, 4 * pixels * static_cast<std::uint64_t>(std::max(samples, 1)))) return;
    buffer->format = format;
    buffer->width = width;
    buffer->height = height;
    buffer->samples = samples;
}

void glDeleteRenderbuffers(GLsizei count, const GLuint* names) {
    GlState& gl = now();
    for (GLsizei i = 0; i < count; ++i) {
        if (const auto found = gl.renderbuffers.find(names[i]); found != gl.renderbuffers.end())
            gl.record.bytes -= found->second.bytes;
        gl.erase(gl.renderbuffers, names[i], "a renderbuffer");
        if (gl.renderbuffer == names[i]) gl.renderbuffer = 0;
    }
}

void glGenFramebuffers(GLsizei count, GLuint* names) {
    now().create(now().framebuffers, count, names);
}

void glBindFramebuffer(GLenum target, GLuint name) {
    GlState& gl = now();
    if (target != GL_READ_FRAMEBUFFER) gl.bind(gl.framebuffers, name, gl.draw_framebuffer, "framebuffer");
    if (target != GL_DRAW_FRAMEBUFFER) gl.bind(gl.framebuffers, name, gl.read_framebuffer, "framebuffer");
}

void glFramebufferRenderbuffer(GLenum, GLenum attachment, GLenum, GLuint name) {
    GlState& gl = now();
    Framebuffer* framebuffer = gl.find(gl.framebuffers, gl.draw_framebuffer, "the framebuffer to attach to");
    if (framebuffer)
        gl.bind(gl.renderbuffers, name, attachment == GL_DEPTH_ATTACHMENT ? framebuffer->depth : framebuffer->color,
                "renderbuffer");
}

GLenum glCheckFramebufferStatus(GLenum target) {
    return now().status_of(target == GL_READ_FRAMEBUFFER ? now().read_framebuffer : now().draw_framebuffer);
}

void glDeleteFramebuffers(GLsizei count, const GLuint* names) {
    GlState& gl = now();
    for (GLsizei i = 0; i < count; ++i) {
        gl.erase(gl.framebuffers, names[i], "a framebuffer");
        if (gl.draw_framebuffer == names[i]) gl.draw_framebuffer = 0;
        if (gl.read_framebuffer == names[i]) gl.read_framebuffer = 0;
    }
}

// Drawing.

void glClearColor(GLfloat red, GLfloat green, GLfloat blue, GLfloat alpha) {
    now().clear_color = {red, green, blue, alpha};
}

void glClear(GLbitfield what) {
    GlState& gl = now();
    Renderbuffer* colors = gl.colors_of(gl.draw_framebuffer, "clearing");
    if (!colors) return;
    if ((what & GL_DEPTH_BUFFER_BIT) != 0 && !gl.writes_depth) gl.misuse("depth is cleared while its writing is off");
    if (gl.enabled.contains(GL_SAMPLE_MASK)) gl.misuse("some samples are cleared and others not");
    const lodestream::Vec4f& color = gl.clear_color;
    if ((what & GL_COLOR_BUFFER_BIT) != 0)
        colors->color = {to_srgb8(color.r), to_srgb8(color.g), to_srgb8(color.b),
                         static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(color.a, 0.0f, 1.0f)))};
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void* offset) {
    GlState& gl = now();
    const VertexArray* array = gl.find(gl.vertex_arrays, gl.vertex_array, "the vertex array of a drawing");
    const Buffer* elements = array ? gl.find(gl.buffers, array->elements, "the indices of a drawing") : nullptr;
    if (!elements) return;
    if (type != GL_UNSIGNED_INT || count % 3 != 0) gl.misuse("indices that are not 32 bits each, three a triangle");
    const auto from = reinterpret_cast<std::size_t>(offset);
    std::vector<std::uint32_t> vertices(static_cast<std::size_t>(count));
    if (from + vertices.size() * 4 > elements->bytes.size()) return gl.misuse("indices are read beyond their buffer");
    if (!vertices.empty()) std::memcpy(vertices.data(), elements->bytes.data() + from, vertices.size() * 4);
    gl.draw(mode, 1, vertices);
}

void glDrawArraysInstanced(GLenum mode, GLint first, GLsizei count, GLsizei instances) {
    std::vector<std::uint32_t> vertices;
    for (GLsizei i = 0; i < count; ++i) vertices.push_back(static_cast<std::uint32_t>(first + i));
    now().draw(mode, instances, vertices);
}

void glDrawArrays(GLenum mode, GLint first, GLsizei count) {
    glDrawArraysInstanced(mode, first, count, 1);
}

void glBlitFramebuffer(GLint, GLint, GLint read_width, GLint read_height, GLint, GLint, GLint width, GLint height,
                       GLbitfield, GLenum) {
    GlState& gl = now();
    const Renderbuffer* from = gl.colors_of(gl.read_framebuffer, "copying from");
    Renderbuffer* to = gl.colors_of(gl.draw_framebuffer, "copying to");
    if (!from || !to) return;
    if (from->format != to->format || to->samples > 0 || read_width != width || read_height != height)
        return gl.wrong(GL_INVALID_OPERATION, "samples are resolved between framebuffers that do not fit");
    if (width != from->width || height != from->height || width != to->width || height != to->height)
        gl.misuse("only a part of the picture is resolved");
    to->color = from->color;
}

void glReadPixels(GLint, GLint, GLsizei width, GLsizei height, GLenum, GLenum, void* pixels) {
    GlState& gl = now();
    const Renderbuffer* from = gl.colors_of(gl.read_framebuffer, "reading");
    if (!from) return;
    if (from->samples > 0) return gl.wrong(GL_INVALID_OPERATION, "samples are read that are not resolved");
    if (width != from->width || height != from->height) gl.misuse("another part of the picture is read than it has");
    if (gl.pack_alignment > 4) gl.misuse("rows are read that do not lie together");
    auto* out = static_cast<std::uint8_t*>(pixels);
    for (std::size_t i = 0; i < static_cast<std::size_t>(width) * static_cast<std::size_t>(height); ++i)
        out = std::copy(from->color.begin(), from->color.end(), out);
}

// Which objects live.

GLboolean glIsBuffer(GLuint name) {
    return now().buffers.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsTexture(GLuint name) {
    return now().textures.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsRenderbuffer(GLuint name) {
    return now().renderbuffers.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsFramebuffer(GLuint name) {
    return now().framebuffers.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsVertexArray(GLuint name) {
    return now().vertex_arrays.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsShader(GLuint name) {
    return now().shaders.contains(name) ? GL_TRUE : GL_FALSE;
}
GLboolean glIsProgram(GLuint name) {
    return now().programs.contains(name) ? GL_TRUE : GL_FALSE;
}

}  // extern "C"
// NOLINTEND(readability-identifier-naming)
