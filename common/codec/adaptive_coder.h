// Private to the codec: an arithmetic coder of yes-or-no decisions, each under a model that learns how likely it is
// (Moffat et al. 1998, "Arithmetic coding revisited"), and beside it whole bits that nothing is known about.
// Encoder and decoder have the same calls, so one function that is given either serves both directions.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace lodestream::codec {

// How likely a decision is "yes": quick to learn at first, later in sixtieths of what surprises it.
class Decision {
  public:
    std::uint32_t yes() const { return yes_; }  // of one << probability_bits, neither none nor all of them
    void learn(bool was_yes) {
        const std::int32_t target = margin + (((1 << probability_bits) - 2 * margin) & -static_cast<int>(was_yes));
        yes_ = static_cast<std::uint16_t>(yes_ + (((target - yes_) * rates[seen_]) >> rate_bits));
        seen_ = static_cast<std::uint16_t>(seen_ + (seen_ + 1u < rates.size() ? 1u : 0u));
    }

    static constexpr int probability_bits = 15;

  private:
    static constexpr int rate_bits = 14, margin = 16;
    static constexpr std::size_t slowest_rate = 60;
    static constexpr std::array<std::int32_t, slowest_rate> rates = [] {
        std::array<std::int32_t, slowest_rate> result{};
        for (std::size_t n = 0; n < result.size(); ++n)
            result[n] = static_cast<std::int32_t>((1 << rate_bits) / (static_cast<double>(n) + 1.6));
        return result;
    }();

    std::uint16_t yes_ = 1 << (probability_bits - 1);
    std::uint16_t seen_ = 0;
};

inline constexpr int max_bits_at_once = 25;
inline constexpr std::size_t left_out_bytes = 8;  // zeros at the end of decisions, at most

class AdaptiveEncoder {
  public:
    static constexpr bool decodes = false;

    bool decide(Decision& decision, bool value) {
        const std::uint64_t share = (range_ >> Decision::probability_bits) * decision.yes();
        if (!value) add(share);
        range_ = value ? share : range_ - share;
        decision.learn(value);
        if (range_ >> 32 == 0) {
            words_.push_back(static_cast<std::uint32_t>(low_ >> 32));
            low_ <<= 32;
            range_ <<= 32;
        }
        return value;
    }
    // The lowest `count` bits. pre: value < 2^count, count <= max_bits_at_once
    std::uint32_t bits(std::uint32_t value, int count) {
        pending_ |= std::uint64_t{value} << pending_bits_;
        for (pending_bits_ += count; pending_bits_ >= 8; pending_bits_ -= 8, pending_ >>= 8)
            bits_.push_back(static_cast<std::byte>(pending_ & 0xff));
        return value;
    }

    // Both are to be asked for once, at the end. Of the decisions' last words what is zero is left out.
    std::vector<std::byte> decisions() {
        add(0xffffffffu);
        words_.push_back(static_cast<std::uint32_t>(low_ >> 32));
        std::vector<std::byte> bytes;
        for (const std::uint32_t word : words_)
            for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::byte>(word >> shift & 0xff));
        for (std::size_t i = 0; i < left_out_bytes && !bytes.empty() && bytes.back() == std::byte{0}; ++i)
            bytes.pop_back();
        return bytes;
    }
    std::vector<std::byte> whole_bits() {
        if (pending_bits_ > 0) bits_.push_back(static_cast<std::byte>(pending_));
        return std::move(bits_);
    }

  private:
    void add(std::uint64_t value) {
        low_ += value;
        if (low_ >= value) return;
        for (std::size_t i = words_.size(); i-- > 0 && ++words_[i] == 0;) {
        }
    }

    std::uint64_t low_ = 0, range_ = ~std::uint64_t{0};
    std::vector<std::uint32_t> words_;
    std::uint64_t pending_ = 0;
    int pending_bits_ = 0;
    std::vector<std::byte> bits_;
};

// Of any bytes: behind their ends it reads zeros, see is_at_end().
class AdaptiveDecoder {
  public:
    static constexpr bool decodes = true;

    AdaptiveDecoder(std::span<const std::byte> decisions, std::span<const std::byte> whole_bits)
        : decisions_(decisions), bits_(whole_bits) {
        code_ = std::uint64_t{next_word()} << 32;
        code_ |= next_word();
    }

    [[gnu::always_inline]] inline bool decide(Decision& decision, bool = false) {
        const std::uint64_t share = (range_ >> Decision::probability_bits) * decision.yes();
        const bool value = code_ < share;
        // Without a branch, which would be foreseen as badly as the decision is.
        const std::uint64_t if_yes = 0 - static_cast<std::uint64_t>(value);
        const std::uint64_t rest = range_ - share;
        range_ = rest ^ ((rest ^ share) & if_yes);
        code_ -= share & ~if_yes;
        decision.learn(value);
        if (range_ >> 32 == 0) {
            range_ <<= 32;
            code_ = code_ << 32 | next_word();
        }
        return value;
    }
    // pre: count <= max_bits_at_once
    std::uint32_t bits(std::uint32_t, int count) {
        std::uint32_t word = 0;
        const std::size_t first = next_bit_ / 8;
        if (first + sizeof word <= bits_.size())
            std::memcpy(&word, bits_.data() + first, sizeof word);
        else
            for (std::size_t i = first; i < bits_.size(); ++i)
                word |= std::to_integer<std::uint32_t>(bits_[i]) << 8 * (i - first);
        word >>= next_bit_ % 8;
        next_bit_ += static_cast<std::size_t>(count);
        return word & ((1u << count) - 1u);
    }

    // Whether what was read is all there is, and no more.
    bool is_at_end() const {
        return next_word_ >= decisions_.size() &&
               next_word_ <= decisions_.size() + left_out_bytes + sizeof(std::uint64_t) &&
               (next_bit_ + 7) / 8 == bits_.size();
    }

  private:
    std::uint32_t next_word() {
        std::uint32_t word = 0;
        if (next_word_ + sizeof word <= decisions_.size()) {
            std::memcpy(&word, decisions_.data() + next_word_, sizeof word);
            word = __builtin_bswap32(word);
        } else {
            for (std::size_t i = next_word_; i < next_word_ + sizeof word; ++i)
                word = word << 8 | (i < decisions_.size() ? std::to_integer<std::uint32_t>(decisions_[i]) : 0u);
        }
        next_word_ += sizeof word;
        return word;
    }

    std::span<const std::byte> decisions_, bits_;
    std::size_t next_word_ = 0, next_bit_ = 0;
    std::uint64_t code_ = 0, range_ = ~std::uint64_t{0};
};

// Whole numbers of either sign, small ones the likelier ones: how many bits a number has, under a model; its sign and
// what is below its first bit as they are, for a model of those learns less than it costs.
class NumberModel {
  public:
    static constexpr int max_bits = max_bits_at_once + 2;

    // pre: |value| < 2^max_bits
    template <class Coder>
    std::int32_t code(Coder& coder, std::int32_t value) {
        const auto magnitude = static_cast<std::uint32_t>(std::abs(value));
        const int length = code_length(coder, std::bit_width(magnitude));
        if (length == 0) return 0;
        const bool negative = coder.bits(value < 0 ? 1 : 0, 1) != 0;
        std::uint32_t result = 1;
        int rest = length - 1;
        result = result << rest | coder.bits(magnitude & ((1u << rest) - 1u), rest);
        return negative ? -static_cast<std::int32_t>(result) : static_cast<std::int32_t>(result);
    }

  private:
    static constexpr int most_short = 15;

    template <class Coder>
    int code_length(Coder& coder, int length) {
        const int code = code_tree(coder, short_, std::min(length, most_short));
        if (code < most_short) return code;
        return std::min(most_short + code_tree(coder, long_, length - most_short), max_bits);
    }

    template <class Coder>
    static int code_tree(Coder& coder, std::array<Decision, 16>& tree, int value) {
        std::size_t node = 1;
        for (int level = 4; level-- > 0;)
            node = 2 * node + (coder.decide(tree[node], (value >> level & 1) != 0) ? 1 : 0);
        return static_cast<int>(node) - 16;
    }

    std::array<Decision, 16> short_, long_;
};

}  // namespace lodestream::codec
