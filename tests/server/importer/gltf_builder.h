#pragma once

#include <string>

#include "tests/server/importer/inputs.h"

namespace lodestream::testing {

// Collects views and accessors over one binary chunk; the rest of the JSON is given as text.
class GltfBuilder {
  public:
    int view(const std::string& data, const std::string& more = "") {
        while (binary_.size() % 4 != 0) binary_ += '\0';
        add(views_, "{\"buffer\":0,\"byteOffset\":" + std::to_string(binary_.size()) +
                        ",\"byteLength\":" + std::to_string(data.size()) + more + "}");
        binary_ += data;
        return view_count_++;
    }
    int raw_view(const std::string& json) {
        add(views_, json);
        return view_count_++;
    }
    int accessor(int view, int component_type, std::size_t count, const std::string& type,
                 const std::string& more = "") {
        std::string json = "{";
        if (view >= 0) json += "\"bufferView\":" + std::to_string(view) + ",";
        json += "\"componentType\":" + std::to_string(component_type) + ",\"count\":" + std::to_string(count);
        return raw_accessor(json + ",\"type\":\"" + type + "\"" + more + "}");
    }
    int raw_accessor(const std::string& json) {
        add(accessors_, json);
        return accessor_count_++;
    }
    std::size_t binary_size() const { return binary_.size(); }

    // `rest`: further members, as "\"meshes\":[…],\"nodes\":[…]".
    std::string glb(const std::string& rest, const std::string& more_buffers = "") const {
        return glb_of(
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":" + std::to_string(binary_.size()) + "}" +
                more_buffers + "],\"bufferViews\":[" + views_ + "],\"accessors\":[" + accessors_ + "]," + rest + "}",
            binary_);
    }

  private:
    static void add(std::string& list, const std::string& json) { list += (list.empty() ? "" : ",") + json; }

    std::string binary_, views_, accessors_;
    int view_count_ = 0, accessor_count_ = 0;
};

inline constexpr int gl_byte = 5120, gl_unsigned_byte = 5121, gl_short = 5122, gl_unsigned_short = 5123,
                     gl_unsigned_int = 5125, gl_float = 5126;

inline std::string floats(std::initializer_list<float> values) {
    return BinaryWriter().put_all(values).data();
}
inline std::string shorts(std::initializer_list<std::uint16_t> values) {
    return BinaryWriter().put_all(values).data();
}

// The triangle (0,0,0) (1,0,0) (0,1,0) as accessor 0.
inline GltfBuilder triangle_builder() {
    GltfBuilder builder;
    builder.accessor(builder.view(floats({0, 0, 0, 1, 0, 0, 0, 1, 0})), gl_float, 3, "VEC3");
    return builder;
}

inline const std::string one_mesh = "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]";
inline const std::string one_node = "\"nodes\":[{\"mesh\":0}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0";

inline std::string mesh_of(const std::string& primitive) {
    return "\"meshes\":[{\"primitives\":[{" + primitive + "}]}]";
}

inline Result<mesh::Model> import_glb(const std::string& glb,
                                      const importer::SideFiles& files = importer::no_side_files(),
                                      const importer::Limits& limits = {}) {
    return import_text(glb, importer::Format::glb, files, limits);
}

}  // namespace lodestream::testing
