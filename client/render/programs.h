// The shader programs, one for each style and look that is drawn. Private to this folder. All are of the current
// context.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "client/render/gl_objects.h"
#include "common/base/result.h"

namespace lodestream::render {

// What a triangle's colour takes beside the light and its material's factors: what it does not take is left out of its
// program. Discs have colours and nothing else.
struct Look {
    bool has_colors = false;  // of vertices
    bool has_base_color_image = false, has_emissive_image = false;
    bool is_masked = false;
    bool is_textured() const { return has_base_color_image || has_emissive_image; }
};

// Locations are -1 where the program has no such uniform.
struct Program {
    GLuint id = 0;
    GLint clip_from_scene = -1, view_from_scene = -1, picture = -1, offset = -1, eye = -1, lights = -1,
          light_count = -1, phong = -1, base_color = -1, emissive = -1, alpha_cutoff = -1, disc = -1, share = -1;
};

inline bool is_of_discs(const Program& program) {
    return program.disc >= 0;
}

// Links a pair of shaders behind `head`, the version and what is defined. Errors: internal, with the driver's words.
Result<GLuint> link(const std::string& head, const char* vertex, const char* fragment);

class Programs {
  public:
    Programs() = default;
    Programs(const Programs&) = delete;
    Programs& operator=(const Programs&) = delete;
    ~Programs();

    // Makes those of this style and look, whole and fading, where they are not there yet; nothing is linked while a
    // frame is drawn. Errors: internal, with the driver's words.
    Status link(Style style, const Look& look);

    // pre: linked
    const Program& at(Style style, const Look& look, bool fades) const;

    void for_each(const std::function<void(const Program&)>& take) const;

  private:
    struct Pair {
        Program whole, fading;
    };
    std::map<std::uint32_t, Pair> pairs_;  // by style and look
};

}  // namespace lodestream::render
