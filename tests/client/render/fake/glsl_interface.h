// What a GLSL ES 3.00 shader takes and gives, read from its text after its preprocessor lines: enough of the language
// for the renderer's shaders.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/result.h"

namespace lodestream::testing {

struct GlslVariable {
    std::string type;          // "vec3"
    bool is_flat = false;      // of what goes from one stage to the next
    int location = -1;         // as laid out; -1 where the text says none
    std::size_t elements = 1;  // of an array
    friend bool operator==(const GlslVariable&, const GlslVariable&) = default;
};

struct GlslInterface {
    std::string version;  // "300 es"
    std::map<std::string, GlslVariable> uniforms, ins, outs;
};

// Components of a value: 3 of "vec3", 16 of "mat4", 1 of scalars and samplers.
std::size_t components_of(std::string_view type);

// Errors: invalid_input (a conditional without its end, brackets that do not close, no main).
Result<GlslInterface> glsl_interface(const std::string& source);

}  // namespace lodestream::testing
