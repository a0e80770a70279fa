#include "server/live/transient_files.h"

#include <utility>

namespace lodestream::live {

Result<TransientFiles::Kept> TransientFiles::put(std::span<const std::byte> glb) {
    const std::lock_guard lock(mutex_);
    Result<store::StoredFile> file = store_.put_transient("glb", glb);
    if (!file) return file.error();
    ++keepers_[file->hash];
    FileKeeper keeper(static_cast<const void*>(this),
                      [self = shared_from_this(), hash = file->hash](const void*) { self->release(hash); });
    return Kept{*std::move(file), std::move(keeper)};
}

void TransientFiles::release(const std::string& hash) {
    const std::lock_guard lock(mutex_);
    if (--keepers_[hash] > 0) return;
    keepers_.erase(hash);
    released_.push_back({hash, Clock::now()});
}

void TransientFiles::sweep(Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    for (; !released_.empty() && released_.front().at + transient_grace <= now; released_.pop_front())
        if (!keepers_.contains(released_.front().hash))
            static_cast<void>(store_.remove_transient(released_.front().hash, "glb"));
}

}  // namespace lodestream::live
