#include <fstream>
#include <system_error>

#include "server/importer/importer.h"
#include "server/importer/whole_file.h"

namespace lodestream::importer {
namespace {

namespace fs = std::filesystem;

bool is_below(const fs::path& file, const fs::path& folder) {
    const fs::path relative = file.lexically_relative(folder);
    return !relative.empty() && *relative.begin() != ".." && *relative.begin() != ".";
}

bool is_plain_relative(const std::string& name) {
    return !name.empty() && name.find('\0') == std::string::npos && name.find("://") == std::string::npos &&
           name.rfind("data:", 0) != 0 && name.rfind("file:", 0) != 0 && !fs::path(name).is_absolute();
}

Result<std::vector<std::byte>> read_below(const fs::path& folder, const std::string& name, std::uint64_t max_bytes) {
    if (!is_plain_relative(name)) return invalid_input("\"" + name + "\" is not a relative file name");
    std::error_code error;
    const fs::path base = fs::canonical(folder, error);
    if (error) return fail(ErrorCode::not_found, "folder of \"" + name + "\" is not there");
    if (!is_below((base / name).lexically_normal(), base))
        return invalid_input("\"" + name + "\" leads out of the model's folder");
    const fs::path file = fs::canonical(base / name, error);
    if (error) return fail(ErrorCode::not_found, "\"" + name + "\" is not beside the model");
    if (!is_below(file, base)) return invalid_input("\"" + name + "\" links out of the model's folder");
    return read_whole_file(file, max_bytes);
}

}  // namespace

Result<std::vector<std::byte>> read_whole_file(const fs::path& file, std::uint64_t max_bytes) {
    const std::string name = file.filename().string();
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status)) return fail(ErrorCode::not_found, name + " does not exist");
    if (!fs::is_regular_file(status)) return invalid_input(name + " is not a file");
    const std::uintmax_t size = fs::file_size(file, error);
    if (error) return fail(ErrorCode::io, name + " cannot be read: " + error.message());
    if (size > max_bytes)
        return fail(ErrorCode::limit_exceeded, name + " has " + std::to_string(size) +
                                                   " bytes, more than the limit of " + std::to_string(max_bytes));
    std::vector<std::byte> bytes(size);
    std::ifstream stream(file, std::ios::binary);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (!stream || static_cast<std::uintmax_t>(stream.gcount()) != size)
        return fail(ErrorCode::io, name + " cannot be read");
    return bytes;
}

SideFiles read_files_below(const fs::path& folder, std::uint64_t max_bytes) {
    return [base = folder.empty() ? fs::path(".") : folder, max_bytes](const std::string& name) {
        return read_below(base, name, max_bytes);
    };
}

SideFiles no_side_files() {
    return [](const std::string& name) -> Result<std::vector<std::byte>> {
        return fail(ErrorCode::not_found, "\"" + name + "\" is another file, and only one was given");
    };
}

}  // namespace lodestream::importer
