// Strict reading of JSON objects with messages that name the field's path. Private to proto.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/math.h"
#include "common/base/result.h"
#include "proto/messages.h"

namespace lodestream::proto {

using Json = nlohmann::json;

// Whole, well formed, at most so deep, every member named once, every number finite.
Result<Json> parse_json(std::string_view text, std::size_t max_depth = max_json_depth);

// The members of one object. The first thing that is wrong is kept in `error`; whatever is read after it keeps its
// value. null counts as absent.
class Fields {
  public:
    Fields(const Json& object, std::string path, std::optional<Error>& error);

    bool has(const char* name) const { return find(name) != nullptr; }

    template <class T>
    void require(const char* name, T& out) const {
        if (const Json* value = find(name))
            read_value(*value, name, out);
        else
            refuse(name, "is missing");
    }
    template <class T>
    void read(const char* name, T& out) const {
        if (const Json* value = find(name)) read_value(*value, name, out);
    }
    // One of a few names.
    template <class E>
    void read_name(const char* name, E& out, std::initializer_list<std::pair<std::string_view, E>> names) const {
        std::string text;
        read(name, text);
        if (!has(name) || failed()) return;
        std::string allowed;
        for (const auto& [known, value] : names) {
            if (text == known) {
                out = value;
                return;
            }
            allowed += (allowed.empty() ? "\"" : ", \"") + std::string(known) + '"';
        }
        refuse(name, "must be one of " + allowed, find(name));
    }
    std::optional<Fields> object(const char* name) const;
    std::vector<Fields> objects(const char* name) const;

    bool failed() const { return error_->has_value(); }
    void refuse(const std::string& name, const std::string& what, const Json* got = nullptr) const;

  private:
    const Json* find(const char* name) const;
    std::string path_of(const std::string& name) const { return path_.empty() ? name : path_ + "." + name; }

    void read_value(const Json& value, const char* name, bool& out) const;
    void read_value(const Json& value, const char* name, double& out) const;
    void read_value(const Json& value, const char* name, std::string& out) const;
    void read_value(const Json& value, const char* name, std::uint32_t& out) const;
    void read_value(const Json& value, const char* name, std::uint64_t& out) const;
    template <std::size_t Count>
    void read_value(const Json& value, const char* name, std::array<double, Count>& out) const {
        if (!is_numbers(value, Count))
            return refuse(name, "must be an array of " + std::to_string(Count) + " numbers", &value);
        for (std::size_t i = 0; i < Count; ++i) out[i] = value[i].template get<double>();
    }
    void read_value(const Json& value, const char* name, Vec3d& out) const;
    void read_value(const Json& value, const char* name, std::vector<std::string>& out) const;
    void read_value(const Json& value, const char* name, std::vector<std::uint32_t>& out) const;
    template <class T>
    void read_value(const Json& value, const char* name, std::optional<T>& out) const {
        T read{};
        read_value(value, name, read);
        if (!failed()) out = std::move(read);
    }
    static bool is_numbers(const Json& value, std::size_t count);
    bool read_whole(const Json& value, const char* name, std::uint64_t most, std::uint64_t& out) const;

    const Json* object_;
    std::string path_;
    std::optional<Error>* error_;
};

}  // namespace lodestream::proto
