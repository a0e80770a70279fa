// Reads what accessors point at, with every range checked against the bytes that are there.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "server/importer/gltf_document.h"

namespace lodestream::importer {

class GltfAccessors {
  public:
    GltfAccessors(const GltfDocument& document, const Limits& limits);

    // The bytes of a buffer view, decompressed where EXT_meshopt_compression holds them. Valid as long as this object.
    Result<std::span<const std::byte>> view(int index);

    struct Floats {
        std::size_t count = 0;
        int components = 0;
        std::vector<float> values;  // components * count; normalized integers scaled to [0,1] or [-1,1]
    };
    // A numeric accessor of `least` to `most` components and, unless it is any_count, of `count` elements. Sparse parts
    // are applied. `what` is for messages.
    static constexpr std::size_t any_count = ~std::size_t{0};
    Result<Floats> floats(int accessor, int least, int most, std::size_t count, const std::string& what);
    Result<std::vector<std::uint32_t>> indices(int accessor);

  private:
    struct Layout;
    Result<Layout> layout_of(int accessor, std::uint64_t max_count, const std::string& what) const;
    Result<std::vector<std::byte>> packed(int accessor, const Layout& layout);
    Status copy_elements(int view_index, std::uint64_t offset, std::uint64_t count, const Layout& layout, bool strided,
                         std::vector<std::byte>& to);
    Status apply_sparse(int accessor, const Layout& layout, std::vector<std::byte>& elements);
    Result<std::vector<std::byte>> decompress(int index, const tinygltf::Value& extension);

    const GltfDocument& document_;
    const Limits& limits_;
    std::uint64_t buffer_bytes_ = 0;
    std::uint64_t decompressed_bytes_ = 0;
    std::map<int, std::vector<std::byte>> decompressed_;
};

}  // namespace lodestream::importer
