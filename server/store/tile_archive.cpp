#include "server/store/tile_archive.h"

#include <minizip/zip.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <bit>
#include <system_error>
#include <utility>

namespace lodestream::store {

namespace {

constexpr std::uint64_t header_bytes = 30;  // of an entry, before its path
constexpr std::uint32_t no_time =
    (1 << 21) | (1 << 16);  // 1980-01-01, the first that ZIP has: equal tilesets, equal bytes

struct IndexEntry {
    std::array<std::uint64_t, 2> hash;  // of the path
    std::uint64_t offset;               // of the entry's header, from the file's begin
};
static_assert(sizeof(IndexEntry) == 24 && std::endian::native == std::endian::little, "it is written as it is");

IndexEntry index_entry(const std::string& path, std::uint64_t offset) {
    std::array<std::uint64_t, EVP_MAX_MD_SIZE / sizeof(std::uint64_t)> digest{};
    EVP_Digest(path.data(), path.size(), reinterpret_cast<unsigned char*>(digest.data()), nullptr, EVP_md5(), nullptr);
    return {{digest[0], digest[1]}, offset};
}

}  // namespace

struct TileArchive::Impl {
    ~Impl() {
        if (zip) zipClose(zip, nullptr);
        std::error_code ignored;
        std::filesystem::remove(unfinished, ignored);
    }

    Error failed() const { return fail(ErrorCode::io, "cannot write " + file.string()); }

    std::filesystem::path file, unfinished;
    zipFile zip = nullptr;
    std::uint64_t size = 0;
    std::vector<IndexEntry> index;
};

TileArchive::TileArchive(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TileArchive::TileArchive(TileArchive&&) noexcept = default;
TileArchive& TileArchive::operator=(TileArchive&&) noexcept = default;
TileArchive::~TileArchive() = default;

Result<TileArchive> TileArchive::create(const std::filesystem::path& file) {
    auto impl = std::make_unique<Impl>();
    impl->file = file;
    impl->unfinished = file;
    impl->unfinished += ".unfinished";
    std::error_code ignored;
    if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), ignored);
    impl->zip = zipOpen64(impl->unfinished.c_str(), APPEND_STATUS_CREATE);
    if (!impl->zip) return impl->failed();
    return TileArchive(std::move(impl));
}

Status TileArchive::add(const std::string& path, std::span<const std::byte> bytes) {
    if (bytes.size() > max_archived_bytes)
        return fail(ErrorCode::limit_exceeded, path + " has " + std::to_string(bytes.size()) +
                                                   " bytes; an archive takes " + std::to_string(max_archived_bytes) +
                                                   " at most");
    zip_fileinfo info{};
    info.dosDate = no_time;
    constexpr int stored = 0, small_header = 0;
    const bool written = zipOpenNewFileInZip64(impl_->zip, path.c_str(), &info, nullptr, 0, nullptr, 0, nullptr, stored,
                                               0, small_header) == ZIP_OK &&
                         zipWriteInFileInZip(impl_->zip, bytes.data(), static_cast<unsigned>(bytes.size())) == ZIP_OK &&
                         zipCloseFileInZip(impl_->zip) == ZIP_OK;
    if (!written) return impl_->failed();
    impl_->index.push_back(index_entry(path, impl_->size));
    impl_->size += header_bytes + path.size() + bytes.size();
    return Nothing{};
}

Status TileArchive::finish() {
    std::vector<IndexEntry> index = std::move(impl_->index);
    std::sort(index.begin(), index.end(), [](const IndexEntry& a, const IndexEntry& b) { return a.hash < b.hash; });
    if (Status added = add(archive_index_name, std::as_bytes(std::span(index))); !added) return added;
    std::error_code error;
    if (zipClose(std::exchange(impl_->zip, nullptr), nullptr) != ZIP_OK) return impl_->failed();
    std::filesystem::rename(impl_->unfinished, impl_->file, error);
    if (error) return impl_->failed();
    return Nothing{};
}

}  // namespace lodestream::store
