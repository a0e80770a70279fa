#include "server/store/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include "server/store/files.h"

namespace lodestream::store {

Result<MappedFile> MappedFile::open(const std::filesystem::path& file, std::uint64_t max_bytes) {
    const FileDescriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
    struct stat status {};
    if (descriptor.get() < 0 || ::fstat(descriptor.get(), &status) != 0) return file_error(file, "cannot read");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > max_bytes)
        return fail(ErrorCode::limit_exceeded,
                    file.string() + " is larger than " + std::to_string(max_bytes) + " bytes");
    if (size == 0) return MappedFile(std::span<const std::byte>{});
    void* start = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, descriptor.get(), 0);
    if (start == MAP_FAILED) return file_error(file, "cannot map");
    return MappedFile({static_cast<const std::byte*>(start), size});
}

MappedFile::~MappedFile() {
    if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

}  // namespace lodestream::store
