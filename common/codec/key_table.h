// Private to the codec: numbers distinct keys of a fixed count of 32-bit words in the order of their first appearance.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace lodestream::codec {

class KeyTable {
  public:
    static constexpr std::uint32_t none = 0xffffffffu;

    // width: words a key, >= 1.
    explicit KeyTable(std::size_t width) : width_(width), slots_(16, none) {}

    std::uint32_t size() const { return static_cast<std::uint32_t>(keys_.size() / width_); }
    const std::uint32_t* key(std::uint32_t number) const { return keys_.data() + number * width_; }

    std::uint32_t find(const std::uint32_t* key) const { return slots_[slot_of(key)]; }

    std::uint32_t find_or_add(const std::uint32_t* key) {
        if (2 * (std::size_t{size()} + 1) > slots_.size()) grow();
        std::uint32_t& slot = slots_[slot_of(key)];
        if (slot == none) {
            slot = size();
            keys_.insert(keys_.end(), key, key + width_);
        }
        return slot;
    }

  private:
    std::size_t slot_of(const std::uint32_t* key) const {
        std::uint64_t hash = 0;
        for (std::size_t i = 0; i < width_; ++i) {
            hash = (hash ^ key[i]) * 0xd6e8feb86659fd93ull;
            hash ^= hash >> 32;
        }
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = hash & mask;
        while (slots_[slot] != none && !std::equal(key, key + width_, this->key(slots_[slot])))
            slot = (slot + 1) & mask;
        return slot;
    }

    void grow() {
        slots_.assign(slots_.size() * 4, none);
        for (std::uint32_t number = 0; number < size(); ++number) slots_[slot_of(key(number))] = number;
    }

    std::size_t width_;
    std::vector<std::uint32_t> keys_;
    std::vector<std::uint32_t> slots_;  // a power of two of them, at most half used
};

}  // namespace lodestream::codec
