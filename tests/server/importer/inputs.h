// Tiny files in memory for the importer's tests.
#pragma once

#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "server/importer/importer.h"

namespace lodestream::testing {

inline std::vector<std::byte> bytes_of(std::string_view text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return {begin, begin + text.size()};
}

inline importer::SideFiles files_in_memory(std::map<std::string, std::vector<std::byte>> files) {
    return [files = std::move(files)](const std::string& name) -> Result<std::vector<std::byte>> {
        const auto at = files.find(name);
        if (at == files.end()) return fail(ErrorCode::not_found, name + " is not there");
        return at->second;
    };
}

inline Result<mesh::Model> import_text(std::string_view text, importer::Format format,
                                       const importer::SideFiles& files = importer::no_side_files(),
                                       const importer::Limits& limits = {}) {
    return importer::import_model(bytes_of(text), format, files, limits);
}

// Little-endian binary data, written value by value.
class BinaryWriter {
  public:
    template <class T>
    BinaryWriter& put(T value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        data_.append(raw, sizeof value);
        return *this;
    }
    template <class T>
    BinaryWriter& put_all(std::initializer_list<T> values) {
        for (const T value : values) put(value);
        return *this;
    }
    const std::string& data() const { return data_; }
    std::size_t size() const { return data_.size(); }

  private:
    std::string data_;
};

inline std::string glb_of(std::string json, std::string binary) {
    while (json.size() % 4 != 0) json += ' ';
    while (binary.size() % 4 != 0) binary += '\0';
    BinaryWriter file;
    const auto length = static_cast<std::uint32_t>(12 + 8 + json.size() + (binary.empty() ? 0 : 8 + binary.size()));
    file.put_all<std::uint32_t>({0x46546C67, 2, length, static_cast<std::uint32_t>(json.size()), 0x4E4F534A});
    std::string out = file.data() + json;
    if (binary.empty()) return out;
    BinaryWriter head;
    head.put_all<std::uint32_t>({static_cast<std::uint32_t>(binary.size()), 0x004E4942});
    return out + head.data() + binary;
}

inline bool mentions(const std::vector<std::string>& warnings, std::string_view text) {
    for (const std::string& warning : warnings)
        if (warning.find(text) != std::string::npos) return true;
    return false;
}

// A PNG of one grey texel.
inline std::vector<std::byte> tiny_png() {
    static constexpr unsigned char raw[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
        0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
        0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x68, 0x00, 0x00, 0x00, 0x82, 0x00, 0x81,
        0x77, 0xcd, 0x72, 0xb6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    const auto* begin = reinterpret_cast<const std::byte*>(raw);
    return {begin, begin + sizeof raw};
}

}  // namespace lodestream::testing
