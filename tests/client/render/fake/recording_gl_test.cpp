// That the fake names what is wrong: without that, a case that ends without misuse says nothing.
#include "tests/client/render/fake/recording_gl.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/render/fake/glsl_interface.h"

namespace lodestream::testing {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr const char* version_line = "#version 300 es\n";

// A complete picture, program and triangle, drawn without misuse; each case spoils one thing.
class RecordingGlTest : public ::testing::Test {
  protected:
    void SetUp() override {
        glGenRenderbuffers(1, &color);
        glBindRenderbuffer(GL_RENDERBUFFER, color);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, 0, GL_SRGB8_ALPHA8, 8, 8);
        glGenFramebuffers(1, &framebuffer);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color);
        glViewport(0, 0, 8, 8);
        program =
            linked("layout(location = 0) in vec3 a_position;\nuniform float u_scale;\n", "uniform vec4 u_color;\n");
        glUseProgram(program);
        glUniform1f(glGetUniformLocation(program, "u_scale"), 2.0f);
        glUniform4f(glGetUniformLocation(program, "u_color"), 1, 2, 3, 4);
        glGenVertexArrays(1, &array);
        glBindVertexArray(array);
        glGenBuffers(2, buffers.data());
        glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
        const std::array<float, 9> positions{0, 0, 0, 1, 0, 0, 0, 1, 0};
        glBufferData(GL_ARRAY_BUFFER, sizeof positions, positions.data(), GL_STATIC_DRAW);
        glEnableVertexAttribArray(0);
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 12, nullptr);
        put_indices({0, 1, 2});
    }

    static GLuint compiled(GLenum stage, const std::string& declarations) {
        const std::string source = version_line + declarations + "void main() {}\n";
        const char* text = source.c_str();
        const GLuint shader = glCreateShader(stage);
        glShaderSource(shader, 1, &text, nullptr);
        glCompileShader(shader);
        return shader;
    }

    static GLuint linked(const std::string& vertex, const std::string& fragment) {
        const GLuint first = compiled(GL_VERTEX_SHADER, vertex), second = compiled(GL_FRAGMENT_SHADER, fragment);
        const GLuint made = glCreateProgram();
        glAttachShader(made, first);
        glAttachShader(made, second);
        glLinkProgram(made);
        glDeleteShader(first);
        glDeleteShader(second);
        return made;
    }

    static bool links(const std::string& vertex, const std::string& fragment) {
        const GLuint made = linked(vertex, fragment);
        GLint is_linked = GL_FALSE;
        glGetProgramiv(made, GL_LINK_STATUS, &is_linked);
        glDeleteProgram(made);
        return is_linked == GL_TRUE;
    }

    void put_indices(const std::vector<GLuint>& indices) {
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
        glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * indices.size()), indices.data(),
                     GL_STATIC_DRAW);
    }

    std::vector<std::string> misuses_of_drawing(GLsizei corners = 3) {
        glDrawElements(GL_TRIANGLES, corners, GL_UNSIGNED_INT, nullptr);
        return gl.record().misuses;
    }

    RecordingGl gl;
    GLuint color = 0, framebuffer = 0, program = 0, array = 0;
    std::array<GLuint, 2> buffers{};
};

TEST_F(RecordingGlTest, RecordsWhatIsDrawn) {
    EXPECT_THAT(misuses_of_drawing(), IsEmpty());
    ASSERT_EQ(gl.record().draws.size(), 1u);
    const GlDraw& draw = gl.record().draws[0];
    EXPECT_EQ(draw.count, 3);
    EXPECT_THAT(draw.uniforms.at("u_color"), ElementsAre(1, 2, 3, 4));
    EXPECT_THAT(draw.vertices.at("a_position"), ElementsAre(Vec4f(0, 0, 0, 1), Vec4f(1, 0, 0, 1), Vec4f(0, 1, 0, 1)));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
}

TEST_F(RecordingGlTest, NamesReadsBeyondBuffers) {
    put_indices({0, 1, 3});
    EXPECT_THAT(misuses_of_drawing(), ElementsAre("a_position is read beyond its buffer"));
    EXPECT_THAT(misuses_of_drawing(6).back(), "indices are read beyond their buffer");
}

TEST_F(RecordingGlTest, NamesAnAttributeWhoseBufferIsDeleted) {
    glDeleteBuffers(1, buffers.data());
    EXPECT_THAT(misuses_of_drawing(),
                ElementsAre("a_position is read from a buffer that is deleted or was never there"));
}

TEST_F(RecordingGlTest, NamesUniformsThatWereNeverSetOrSetWrongly) {
    const GLuint other = linked("layout(location = 0) in vec3 a_position;\nuniform vec4 u_lights[2];\n", "");
    glUseProgram(other);
    const GLint lights = glGetUniformLocation(other, "u_lights");
    EXPECT_THAT(misuses_of_drawing(), ElementsAre("u_lights was never set"));
    const std::array<float, 12> values{};
    glUniform4fv(lights, 3, values.data());
    glUniform3f(lights, 0, 0, 0);
    glUniform1f(glGetUniformLocation(other, "u_missing"), 0);
    glUniform4f(lights, NAN, 0, 0, 0);
    EXPECT_THAT(gl.record().misuses,
                ElementsAre("u_lights was never set", "u_lights is set beyond its end",
                            "u_lights is set as another type than vec4",
                            "a uniform that the program does not have is set", "u_lights is not finite"));
}

TEST_F(RecordingGlTest, NamesTexturesThatAreNotComplete) {
    glUseProgram(linked("layout(location = 0) in vec3 a_position;\n", "uniform sampler2D u_texture;\n"));
    glUniform1i(0, 1);
    EXPECT_THAT(misuses_of_drawing(), ElementsAre("the texture of u_texture: none is bound"));
    GLuint texture = 0;
    glGenTextures(1, &texture);
    glActiveTexture(GL_TEXTURE1);
    glBindTexture(GL_TEXTURE_2D, texture);
    const std::array<GLubyte, 4> texel{};
    glTexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, texel.data());
    EXPECT_EQ(misuses_of_drawing().back(), "u_texture reads a texture that is not complete");  // without its mip levels
    gl.record().misuses.clear();
    glGenerateMipmap(GL_TEXTURE_2D);
    EXPECT_THAT(misuses_of_drawing(), IsEmpty());
}

TEST_F(RecordingGlTest, NamesObjectsDeletedTwiceUsedAfterwardsOrOfAnotherContext) {
    glDeleteVertexArrays(1, &array);
    glDeleteVertexArrays(1, &array);
    glBindVertexArray(array);
    EXPECT_THAT(gl.record().misuses,
                ElementsAre("a vertex array deleted twice", "a bound vertex array: it is deleted"));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_INVALID_OPERATION));
    RecordingGl other;
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glDeleteBuffers(1, buffers.data());
    EXPECT_THAT(other.record().misuses, ElementsAre("a bound buffer: this context never had it",
                                                    "a buffer deleted that this context never had"));
}

TEST_F(RecordingGlTest, AProgramInUseOutlivesItsDeletion) {
    glDeleteProgram(program);
    EXPECT_EQ(glIsProgram(program), GL_TRUE);
    glUseProgram(0);
    EXPECT_EQ(glIsProgram(program), GL_FALSE);
}

TEST_F(RecordingGlTest, NamesVertexStateOutsideAVertexArray) {
    glBindVertexArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    EXPECT_THAT(gl.record().misuses, ElementsAre("the vertex array of indices: none is bound"));
}

TEST_F(RecordingGlTest, NamesPicturesThatDoNotFit) {
    glViewport(0, 0, 8, 9);
    EXPECT_THAT(misuses_of_drawing(), ElementsAre("the viewport is not the picture's"));
    glDepthMask(GL_FALSE);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    EXPECT_EQ(gl.record().misuses.back(), "depth is cleared while its writing is off");
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    EXPECT_EQ(misuses_of_drawing().back(), "drawing to a framebuffer that is not complete");
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, 4, GL_SRGB8_ALPHA8, 8, 8);
    std::array<std::uint8_t, 256> pixels{};
    glReadPixels(0, 0, 8, 8, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    EXPECT_EQ(gl.record().misuses.back(), "samples are read that are not resolved");
}

TEST_F(RecordingGlTest, NamesWhatAnOlderDriverDoesNotKnow) {
    gl.driver().version = 30;
    glEnable(GL_SAMPLE_MASK);
    glSampleMaski(0, 1);
    glMinSampleShading(1.0f);
    EXPECT_THAT(gl.record().misuses,
                ElementsAre("a capability that this version of OpenGL ES does not know",
                            "glSampleMaski is of OpenGL ES 3.1", "glMinSampleShading is of OpenGL ES 3.2"));
}

TEST_F(RecordingGlTest, HasNoMoreMemoryThanItsDriver) {
    const std::uint64_t bytes = gl.record().bytes;
    EXPECT_EQ(bytes, 8u * 8u * 4u + 36u + 12u);
    gl.driver().memory_bytes = bytes + 4;
    put_indices({0, 1, 2, 0});
    EXPECT_EQ(gl.record().bytes, bytes + 4);
    put_indices({0, 1, 2, 0, 1, 2});
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_OUT_OF_MEMORY));
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
    EXPECT_EQ(gl.record().bytes, bytes - 12);
    glDeleteBuffers(2, buffers.data());
    glDeleteRenderbuffers(1, &color);
    EXPECT_EQ(gl.record().bytes, 0u);
    EXPECT_THAT(gl.record().misuses, IsEmpty());
}

TEST_F(RecordingGlTest, LinksStagesThatFitAlone) {
    EXPECT_TRUE(links("out vec4 v_light;\n", "in vec4 v_light;\n"));
    EXPECT_TRUE(links("flat out vec2 v_light;\nout vec4 v_more;\n", "flat in vec2 v_light;\n"));
    EXPECT_FALSE(links("out vec2 v_light;\n", "flat in vec2 v_light;\n"));
    EXPECT_FALSE(links("out vec2 v_light;\n", "in vec4 v_light;\n"));
    EXPECT_FALSE(links("", "in vec4 v_light;\n"));
    gl.driver().links = false;
    EXPECT_FALSE(links("", ""));
}

TEST(GlslInterface, FollowsConditionals) {
    const std::string text =
        "#version 300 es\n#define LONG 3\n#define B\n"
        "#ifdef A\nuniform int a;\n#elif defined(B)\nuniform int b[LONG];\n#else\nuniform int c;\n#endif\n"
        "#if defined(A) || defined(B)\nflat in vec2 d;  // in vec2 not_this;\n#else\nin vec2 e;\n#endif\n"
        "layout(location = 2) in vec3 f;\nvoid main() { }\n";
    const auto read = glsl_interface(text);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->version, "300 es");
    ASSERT_EQ(read->uniforms.size(), 1u);
    EXPECT_EQ(read->uniforms.at("b"), (GlslVariable{"int", false, -1, 3}));
    ASSERT_EQ(read->ins.size(), 2u);
    EXPECT_EQ(read->ins.at("d"), (GlslVariable{"vec2", true, -1, 1}));
    EXPECT_EQ(read->ins.at("f"), (GlslVariable{"vec3", false, 2, 1}));
}

TEST(GlslInterface, RefusesTextThatNoCompilerTakes) {
    EXPECT_FALSE(glsl_interface("void main() { "));
    EXPECT_FALSE(glsl_interface("void main() { ) }"));
    EXPECT_FALSE(glsl_interface("#ifdef A\nvoid main() {}\n"));
    EXPECT_FALSE(glsl_interface("#endif\nvoid main() {}\n"));
    EXPECT_FALSE(glsl_interface("uniform int a;\n"));
    EXPECT_FALSE(glsl_interface("#pragma once\nvoid main() {}\n"));
}

}  // namespace
}  // namespace lodestream::testing
