#include "server/store/files.h"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>

#include "server/store/store.h"

namespace lodestream::store {

namespace {

constexpr mode_t file_mode = 0644;
constexpr mode_t folder_mode = 0755;
constexpr std::size_t io_chunk_bytes = 64u << 20;

int open_retrying(const std::filesystem::path& file, int flags, mode_t mode = 0) {
    int descriptor = -1;
    do descriptor = ::open(file.c_str(), flags | O_CLOEXEC, mode);
    while (descriptor < 0 && errno == EINTR);
    return descriptor;
}

Status write_all(const FileDescriptor& out, std::span<const std::byte> bytes, const std::filesystem::path& file) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(out.get(), bytes.data(), std::min(bytes.size(), io_chunk_bytes));
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return file_error(file, "cannot write");
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return Nothing{};
}

}  // namespace

FileDescriptor::~FileDescriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

Error file_error(const std::filesystem::path& file, const char* what) {
    const int code = errno;
    return fail(code == ENOENT ? ErrorCode::not_found : ErrorCode::io,
                std::string(what) + " " + file.string() + ": " + std::generic_category().message(code));
}

std::string sha256_hex(std::span<const std::byte> bytes) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned length = 0;
    [[maybe_unused]] const int done =
        EVP_Digest(bytes.data(), bytes.size(), digest.data(), &length, EVP_sha256(), nullptr);
    assert(done == 1 && length == 32);
    static constexpr const char* digits = "0123456789abcdef";
    std::string hex;
    for (unsigned i = 0; i < length; ++i) {
        hex += digits[digest[i] >> 4];
        hex += digits[digest[i] & 15];
    }
    return hex;
}

Status make_folder(const std::filesystem::path& folder) {
    if (::mkdir(folder.c_str(), folder_mode) == 0) return flush_folder(folder.parent_path());
    if (errno == EEXIST && std::filesystem::is_directory(folder)) return Nothing{};
    return file_error(folder, "cannot make the folder");
}

Status flush_folder(const std::filesystem::path& folder) {
    const FileDescriptor descriptor(open_retrying(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY));
    if (descriptor.get() < 0 || ::fsync(descriptor.get()) != 0) return file_error(folder, "cannot flush the folder");
    return Nothing{};
}

namespace {

Status write_new(const std::filesystem::path& file, std::span<const std::byte> bytes, bool flushes) {
    const FileDescriptor out(open_retrying(file, O_WRONLY | O_CREAT | O_EXCL, file_mode));
    if (out.get() < 0) return file_error(file, "cannot make");
    auto status = write_all(out, bytes, file);
    if (status && flushes && ::fsync(out.get()) != 0) status = file_error(file, "cannot flush");
    if (!status) ::unlink(file.c_str());
    return status;
}

}  // namespace

Status write_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    return write_new(file, bytes, false);
}

Status write_and_flush(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    return write_new(file, bytes, true);
}

Status rename_file(const std::filesystem::path& from, const std::filesystem::path& to) {
    if (::rename(from.c_str(), to.c_str()) != 0) return file_error(to, "cannot rename into");
    return Nothing{};
}

bool is_regular_file(const std::filesystem::path& file, std::uint64_t& bytes) {
    struct stat info {};
    if (::lstat(file.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return false;
    bytes = static_cast<std::uint64_t>(info.st_size);
    return true;
}

Result<FileDescriptor> open_lock(const std::filesystem::path& file) {
    FileDescriptor lock(open_retrying(file, O_RDWR | O_CREAT, file_mode));
    if (lock.get() < 0) return file_error(file, "cannot open");
    return lock;
}

bool try_lock_alone(const FileDescriptor& lock) {
    return ::flock(lock.get(), LOCK_EX | LOCK_NB) == 0;
}

Status lock_shared(const FileDescriptor& lock) {
    while (::flock(lock.get(), LOCK_SH) != 0)
        if (errno != EINTR) return file_error("the store's lock", "cannot take");
    return Nothing{};
}

Result<std::vector<std::byte>> read_file(const std::filesystem::path& path, std::uint64_t max_bytes) try {
    const FileDescriptor in(open_retrying(path, O_RDONLY));
    struct stat info {};
    if (in.get() < 0 || ::fstat(in.get(), &info) != 0) return file_error(path, "cannot open");
    if (!S_ISREG(info.st_mode)) return invalid_input(path.string() + " is not a file");
    const auto size = static_cast<std::uint64_t>(info.st_size);
    if (size > max_bytes)
        return fail(ErrorCode::limit_exceeded,
                    path.string() + " has " + std::to_string(size) + " bytes, more than " + std::to_string(max_bytes));
    std::vector<std::byte> bytes(size);
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t got = ::read(in.get(), bytes.data() + done, std::min(bytes.size() - done, io_chunk_bytes));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return file_error(path, "cannot read");
        if (got == 0) bytes.resize(done);  // it shrank meanwhile
        done += static_cast<std::size_t>(got);
    }
    return bytes;
} catch (const std::bad_alloc&) {
    return fail(ErrorCode::limit_exceeded, path.string() + " does not fit into memory");
}

}  // namespace lodestream::store
