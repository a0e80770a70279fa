#include "proto/json_reader.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace lodestream::proto {

namespace {

constexpr std::size_t max_quoted_length = 40;
constexpr std::uint64_t largest_whole = 1ull << 53;  // doubles, and so most JSON readers, are exact up to here

std::string quoted(const Json& value) {
    std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (text.size() <= max_quoted_length) return text;
    if (value.is_object()) return "an object";
    if (value.is_array()) return "an array";
    std::size_t end = max_quoted_length;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0u) == 0x80u) --end;  // not inside a UTF-8 sequence
    return text.substr(0, end) + "…";
}

// Watches the parser: where it is, how deep, and which members it has seen.
class Watch {
  public:
    explicit Watch(std::size_t max_depth) : max_depth_(max_depth) {}

    bool operator()(int, Json::parse_event_t event, Json& parsed) {
        using Event = Json::parse_event_t;
        if (event == Event::object_start || event == Event::array_start) {
            if (levels_.size() >= max_depth_) refuse("deeper than " + std::to_string(max_depth_) + " levels");
            levels_.emplace_back();
        } else if (event == Event::object_end || event == Event::array_end) {
            levels_.pop_back();
        } else if (event == Event::key) {
            Level& level = levels_.back();
            level.key = parsed.get<std::string>();
            if (!level.seen.insert(level.key).second) refuse(path() + " is given twice");
        }
        return true;
    }

    std::string path() const {
        std::string path;
        for (const Level& level : levels_)
            if (!level.key.empty()) path += (path.empty() ? "" : ".") + level.key;
        return path;
    }

  private:
    struct Level {
        std::string key;
        std::set<std::string> seen;
    };
    struct Refused : std::exception {
        std::string message;
        const char* what() const noexcept override { return message.c_str(); }
    };

    [[noreturn]] static void refuse(std::string message) {
        Refused refused;
        refused.message = std::move(message);
        throw refused;
    }

    std::size_t max_depth_;
    std::vector<Level> levels_;
};

// "[json.exception.parse_error.101] parse error at line 1, column 2: …" without the library's own prefix.
std::string plain_message(const std::exception& e) {
    const std::string message = e.what();
    const auto end = message.starts_with("[json.exception") ? message.find("] ") : std::string::npos;
    return end == std::string::npos ? message : message.substr(end + 2);
}

}  // namespace

Result<Json> parse_json(std::string_view text, std::size_t max_depth) {
    Watch watch(max_depth);
    try {
        return Json::parse(
            text, [&](int depth, Json::parse_event_t event, Json& parsed) { return watch(depth, event, parsed); });
    } catch (const Json::out_of_range& e) {
        const std::string path = watch.path();
        return invalid_input((path.empty() ? "a number" : path) + " must be a finite number: " + plain_message(e));
    } catch (const std::exception& e) {
        return invalid_input("not valid JSON: " + plain_message(e));
    }
}

Fields::Fields(const Json& object, std::string path, std::optional<Error>& error)
    : object_(&object), path_(std::move(path)), error_(&error) {
    if (!failed() && !object.is_object())
        error = invalid_input((path_.empty() ? "the body" : path_) + " must be an object, got " + quoted(object));
}

void Fields::refuse(const std::string& name, const std::string& what, const Json* got) const {
    if (!failed()) *error_ = invalid_input(path_of(name) + " " + what + (got ? ", got " + quoted(*got) : ""));
}

const Json* Fields::find(const char* name) const {
    if (failed()) return nullptr;
    const auto it = object_->find(name);
    return it == object_->end() || it->is_null() ? nullptr : &*it;
}

std::optional<Fields> Fields::object(const char* name) const {
    const Json* value = find(name);
    if (!value) return std::nullopt;
    return Fields(*value, path_of(name), *error_);
}

std::vector<Fields> Fields::objects(const char* name) const {
    std::vector<Fields> result;
    const Json* value = find(name);
    if (!value) return result;
    if (!value->is_array()) {
        refuse(name, "must be an array", value);
        return result;
    }
    for (std::size_t i = 0; i < value->size(); ++i)
        result.emplace_back((*value)[i], path_of(name) + "[" + std::to_string(i) + "]", *error_);
    return result;
}

void Fields::read_value(const Json& value, const char* name, bool& out) const {
    if (!value.is_boolean()) return refuse(name, "must be true or false", &value);
    out = value.get<bool>();
}

void Fields::read_value(const Json& value, const char* name, double& out) const {
    if (!value.is_number()) return refuse(name, "must be a number", &value);
    out = value.get<double>();
}

void Fields::read_value(const Json& value, const char* name, std::string& out) const {
    if (!value.is_string()) return refuse(name, "must be a string", &value);
    out = value.get<std::string>();
}

bool Fields::read_whole(const Json& value, const char* name, std::uint64_t most, std::uint64_t& out) const {
    if (!value.is_number()) {
        refuse(name, "must be a whole number", &value);
        return false;
    }
    const double number = value.get<double>();
    if (!(number >= 0.0) || number > static_cast<double>(most) || number != std::floor(number)) {
        refuse(name, "must be a whole number from 0 to " + std::to_string(most), &value);
        return false;
    }
    out = static_cast<std::uint64_t>(number);
    return true;
}

void Fields::read_value(const Json& value, const char* name, std::uint32_t& out) const {
    std::uint64_t whole = 0;
    if (read_whole(value, name, std::numeric_limits<std::uint32_t>::max(), whole))
        out = static_cast<std::uint32_t>(whole);
}

void Fields::read_value(const Json& value, const char* name, std::uint64_t& out) const {
    read_whole(value, name, largest_whole, out);
}

bool Fields::is_numbers(const Json& value, std::size_t count) {
    return value.is_array() && value.size() == count &&
           std::all_of(value.begin(), value.end(), [](const Json& number) { return number.is_number(); });
}

void Fields::read_value(const Json& value, const char* name, Vec3d& out) const {
    std::array<double, 3> numbers{};
    read_value(value, name, numbers);
    if (!failed()) out = {numbers[0], numbers[1], numbers[2]};
}

void Fields::read_value(const Json& value, const char* name, std::vector<std::string>& out) const {
    if (!value.is_array()) return refuse(name, "must be an array of strings", &value);
    out.clear();
    for (const Json& item : value) {
        if (!item.is_string()) return refuse(name, "must be an array of strings", &value);
        out.push_back(item.get<std::string>());
    }
}

void Fields::read_value(const Json& value, const char* name, std::vector<std::uint32_t>& out) const {
    if (!value.is_array()) return refuse(name, "must be an array of whole numbers", &value);
    out.clear();
    for (const Json& item : value) read_value(item, name, out.emplace_back());
}

}  // namespace lodestream::proto
