// The server's operator new: large blocks ask for large pages. A bake touches hundreds of megabytes once; with pages of
// 4 KiB the kernel takes a tenth of its time to hand them out. Linked into programs; without support for such pages
// (Linux: transparent_hugepage) nothing changes.
#include <malloc.h>
#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace {

constexpr std::size_t large_page = 2 << 20;
constexpr std::size_t min_large_block = 2 * large_page;

// A large block has a mapping of its own, which goes back to the kernel when it is freed. The C library would raise
// that threshold as large blocks are freed, and holes between the later ones would then stay resident. Smaller blocks
// come from a heap that keeps this much at its end for the next ones.
constexpr int kept_heap = 32 << 20;
[[maybe_unused]] const bool set =
    mallopt(M_MMAP_THRESHOLD, static_cast<int>(min_large_block)) != 0 && mallopt(M_TRIM_THRESHOLD, kept_heap) != 0;

void* try_allocate(std::size_t size) noexcept {
    if (size < min_large_block) return std::malloc(size > 0 ? size : 1);
    void* block = nullptr;
    if (posix_memalign(&block, large_page, size) != 0) return nullptr;
    madvise(block, size / large_page * large_page, MADV_HUGEPAGE);  // advice: refused, it changes nothing
    return block;
}

}  // namespace

void* operator new(std::size_t size) {
    for (;;) {
        if (void* block = try_allocate(size)) return block;
        const std::new_handler handler = std::get_new_handler();
        if (!handler) throw std::bad_alloc();
        handler();
    }
}

void operator delete(void* block) noexcept {
    std::free(block);
}

void operator delete(void* block, std::size_t) noexcept {
    std::free(block);
}
