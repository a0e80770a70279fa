// Private to the codec: entropy coding under models that learn how likely each symbol is (Moffat et al. 1998,
// "Arithmetic coding revisited"), by asymmetric numeral systems (Duda 2013), which decode a symbol of sixteen in about
// the time of two yes-or-no decisions. Beside it stand whole bits that nothing is known about. Encoder and decoder have
// the same calls, so one function that is given either serves both directions.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace lodestream::codec {

inline constexpr int probability_bits = 15;
inline constexpr std::uint32_t whole_probability = 1u << probability_bits;
inline constexpr std::size_t slowest_rate = 60;  // symbols seen, from which on a model learns no slower

// By symbols seen, what share of its surprise a model learns, of one << Bits.
template <int Bits>
constexpr std::array<std::int16_t, slowest_rate> rates_after(double before_any) {
    std::array<std::int16_t, slowest_rate> result{};
    for (std::size_t n = 0; n < result.size(); ++n)
        result[n] = static_cast<std::int16_t>((1 << Bits) / (static_cast<double>(n) + before_any));
    return result;
}

// What a symbol has of whole_probability.
struct Share {
    std::uint32_t first, size;
};

// How likely a decision is "yes": quick to learn at first, later in sixtieths of what surprises it.
class Decision {
  public:
    constexpr Decision() = default;
    // Taken for what `seen` decisions were like. pre: percent within 1 … 99, seen < slowest_rate
    constexpr Decision(std::uint32_t percent, std::uint16_t seen)
        : yes_(static_cast<std::uint16_t>(percent * whole_probability / 100)), seen_(seen) {}

    std::uint32_t yes() const { return yes_; }  // neither none nor all of whole_probability
    void learn(bool was_yes) {
        const std::int32_t target = was_yes ? static_cast<std::int32_t>(whole_probability) - margin : margin;
        yes_ = static_cast<std::uint16_t>(yes_ + (((target - yes_) * rates[seen_]) >> rate_bits));
        seen_ = static_cast<std::uint16_t>(seen_ + (seen_ + 1u < rates.size() ? 1u : 0u));
    }

  private:
    static constexpr int rate_bits = 14, margin = 16;
    static constexpr auto rates = rates_after<rate_bits>(1.6);

    std::uint16_t yes_ = whole_probability / 2;
    std::uint16_t seen_ = 0;
};

// How likely each of sixteen symbols is.
class SymbolModel {
  public:
    static constexpr std::size_t count = 16;
    using Weights = std::array<std::uint16_t, count>;  // their sum is at most 2^16

    constexpr SymbolModel() = default;
    // Taken for what `seen` symbols were like. pre: some weight is not 0, seen < slowest_rate
    constexpr SymbolModel(const Weights& weights, std::uint16_t seen) : seen_(seen) {
        std::uint32_t sum = 0, below = 0;
        for (const std::uint32_t weight : weights) sum += weight;
        for (std::size_t i = 0; i < count; below += weights[i++])
            begins_[i] =
                static_cast<std::uint16_t>(i * least_share + below * (whole_probability - count * least_share) / sum);
    }

    // The symbol whose share holds `slot`. pre: slot < whole_probability
    std::size_t at(std::uint32_t slot) const {
        // All sixteen are compared at once: begins rise, so those not above `slot` come first.
        Lanes low, high;
        std::memcpy(&low, begins_.data(), sizeof low);
        std::memcpy(&high, begins_.data() + count / 2, sizeof high);
        const Lanes wanted = Lanes{} + static_cast<std::int16_t>(slot);
        return before(low > wanted) + before(high > wanted) - 1;
    }
    Share share(std::size_t symbol) const {
        const std::uint32_t first = begins_[symbol];
        return {first, begins_[symbol + 1] - first};
    }
    void learn(std::size_t symbol) {
        const std::int16_t rate = rates[seen_];
        const auto& target = targets[symbol];
        for (std::size_t i = 0; i < count; ++i) {
            const auto surprise = static_cast<std::int16_t>(target[i] - begins_[i]);
            begins_[i] = static_cast<std::uint16_t>(begins_[i] + ((surprise * rate) >> rate_bits));
        }
        seen_ = static_cast<std::uint16_t>(seen_ + (seen_ + 1u < rates.size() ? 1u : 0u));
    }

  private:
    using Lanes [[gnu::vector_size(16)]] = std::int16_t;
    using Bytes [[gnu::vector_size(8)]] = std::int8_t;

    // Of eight rising numbers, how many come before those that are above.
    static std::size_t before(Lanes are_above) {
        const auto mask = std::bit_cast<std::uint64_t>(__builtin_convertvector(are_above, Bytes));
        return ((63u ^ static_cast<unsigned>(std::countl_zero(~mask | 1u))) + 1u) / 8u;
    }

    static constexpr int rate_bits = 16, least_share = 4;
    static constexpr auto rates = rates_after<rate_bits>(3.0);
    // Where shares begin if one symbol alone is left, the others with the least share. What is learned rounds down, so
    // no share falls below its target's.
    static constexpr auto targets = [] {
        std::array<std::array<std::int16_t, count>, count> result{};
        for (std::size_t symbol = 0; symbol < count; ++symbol)
            for (std::size_t i = 0; i < count; ++i)
                result[symbol][i] = static_cast<std::int16_t>(
                    i <= symbol ? i * least_share : whole_probability - (count - i) * least_share);
        return result;
    }();
    static constexpr auto even = [] {
        std::array<std::uint16_t, count + 1> result{};
        for (std::size_t i = 0; i <= count; ++i) result[i] = static_cast<std::uint16_t>(i * whole_probability / count);
        return result;
    }();

    std::array<std::uint16_t, count + 1> begins_ = even;
    std::uint16_t seen_ = 0;
};

inline constexpr int max_bits_at_once = 32;
inline constexpr std::uint64_t least_state = 1ull << 31;  // of the numeral system, which starts and ends with it

class AdaptiveEncoder {
  public:
    static constexpr bool decodes = false;

    bool decide(Decision& decision, bool value) {
        const std::uint32_t yes = decision.yes();
        shares_.push_back(value ? Share{0, yes} : Share{yes, whole_probability - yes});
        decision.learn(value);
        return value;
    }
    // pre: value < SymbolModel::count
    std::size_t symbol(SymbolModel& model, std::size_t value) {
        shares_.push_back(model.share(value));
        model.learn(value);
        return value;
    }
    // The lowest `count` bits. pre: value < 2^count, count <= max_bits_at_once
    std::uint32_t bits(std::uint32_t value, int count) {
        pending_ |= std::uint64_t{value} << pending_bits_;
        for (pending_bits_ += count; pending_bits_ >= 8; pending_bits_ -= 8, pending_ >>= 8)
            bits_.push_back(static_cast<std::byte>(pending_ & 0xff));
        return value;
    }

    // Both are to be asked for once, at the end. Symbols are told last to first, as they are read first to last.
    std::vector<std::byte> symbols() const {
        std::vector<std::uint32_t> words;
        std::uint64_t state = least_state;
        for (auto share = shares_.rbegin(); share != shares_.rend(); ++share) {
            if (state >= std::uint64_t{share->size} << (63 - probability_bits)) {
                words.push_back(static_cast<std::uint32_t>(state));
                state >>= 32;
            }
            state = (state / share->size << probability_bits) + state % share->size + share->first;
        }
        words.push_back(static_cast<std::uint32_t>(state));
        words.push_back(static_cast<std::uint32_t>(state >> 32));
        std::reverse(words.begin(), words.end());
        std::vector<std::byte> bytes(words.size() * sizeof(std::uint32_t));
        std::memcpy(bytes.data(), words.data(), bytes.size());
        return bytes;
    }
    std::vector<std::byte> whole_bits() {
        if (pending_bits_ > 0) bits_.push_back(static_cast<std::byte>(pending_));
        return std::move(bits_);
    }

  private:
    std::vector<Share> shares_;
    std::uint64_t pending_ = 0;
    int pending_bits_ = 0;
    std::vector<std::byte> bits_;
};

// Of any bytes: behind their ends it reads zeros, see is_at_end().
class AdaptiveDecoder {
  public:
    static constexpr bool decodes = true;

    AdaptiveDecoder(std::span<const std::byte> symbols, std::span<const std::byte> whole_bits)
        : symbols_(symbols), bits_(whole_bits) {
        state_ = std::uint64_t{next_word()} << 32;
        state_ |= next_word();
    }

    bool decide(Decision& decision, bool = false) {
        const std::uint32_t slot = state_ % whole_probability, yes = decision.yes();
        const bool value = slot < yes;
        advance(value ? Share{0, yes} : Share{yes, whole_probability - yes}, slot);
        decision.learn(value);
        return value;
    }
    // Never inlined: compilers take the loops over shares for vectors only outside of other loops.
    [[gnu::noinline]] std::size_t symbol(SymbolModel& model, std::size_t = 0) {
        const std::uint32_t slot = state_ % whole_probability;
        const std::size_t value = model.at(slot);
        advance(model.share(value), slot);
        model.learn(value);
        return value;
    }
    // pre: count <= max_bits_at_once
    std::uint32_t bits(std::uint32_t, int count) {
        std::uint64_t word = 0;
        const std::size_t first = next_bit_ / 8;
        if (first + sizeof word <= bits_.size())
            std::memcpy(&word, bits_.data() + first, sizeof word);
        else
            for (std::size_t i = first; i < bits_.size(); ++i)
                word |= std::to_integer<std::uint64_t>(bits_[i]) << 8 * (i - first);
        word >>= next_bit_ % 8;
        next_bit_ += static_cast<std::size_t>(count);
        return static_cast<std::uint32_t>(word & ((1ull << count) - 1u));
    }

    // Whether what was read is all there is, and no more.
    bool is_at_end() const {
        return state_ == least_state && next_word_ == symbols_.size() && (next_bit_ + 7) / 8 == bits_.size();
    }

  private:
    void advance(Share share, std::uint32_t slot) {
        state_ = share.size * (state_ >> probability_bits) + slot - share.first;
        if (state_ < least_state) state_ = state_ << 32 | next_word();
    }
    std::uint32_t next_word() {
        std::uint32_t word = 0;
        if (next_word_ + sizeof word <= symbols_.size()) std::memcpy(&word, symbols_.data() + next_word_, sizeof word);
        next_word_ += sizeof word;
        return word;
    }

    std::span<const std::byte> symbols_, bits_;
    std::size_t next_word_ = 0, next_bit_ = 0;
    std::uint64_t state_ = 0;
};

// Whole numbers of either sign, small ones the likelier ones: how many bits a number has, under a model; its sign and
// what is below its first bit as they are, for a model of those learns less than it costs.
class NumberModel {
  public:
    static constexpr int max_bits = 27;

    constexpr NumberModel() = default;
    // Where numbers of about so many bits are likely, as lengths around what was expected mostly are.
    constexpr explicit NumberModel(int bits) : short_(around[static_cast<std::size_t>(std::clamp(bits, 0, longest))]) {}

    // pre: |value| < 2^max_bits
    template <class Coder>
    std::int32_t code(Coder& coder, std::int32_t value) {
        const int length = code_length(coder, std::bit_width(static_cast<std::uint32_t>(std::abs(value))));
        return code_below(coder, value, length);
    }

    // How many bits the number has; what they are is then to be coded by code_below().
    template <class Coder>
    int code_length(Coder& coder, int length) {
        const auto code = static_cast<int>(coder.symbol(short_, static_cast<std::size_t>(std::min(length, longest))));
        if (code < longest) return code;
        const auto beyond = static_cast<int>(coder.symbol(long_, static_cast<std::size_t>(length - longest)));
        return std::min(longest + beyond, max_bits);
    }
    template <class Coder>
    static std::int32_t code_below(Coder& coder, std::int32_t value, int length) {
        const std::uint32_t first = (1u << length) >> 1, is_negative = value < 0 ? 1 : 0;
        const std::uint32_t told =
            coder.bits((static_cast<std::uint32_t>(std::abs(value)) - first) << 1 | is_negative, length);
        const auto magnitude = static_cast<std::int32_t>(first | told >> 1),
                   sign = -static_cast<std::int32_t>(told & 1);
        return (magnitude ^ sign) - sign;
    }

  private:
    static constexpr int longest = SymbolModel::count - 1;  // that is told at once
    static constexpr std::uint16_t seen_before = 6;
    static constexpr auto around = [] {
        constexpr std::array<std::uint16_t, 9> below{28, 20, 12, 6, 3, 2, 1, 1, 1}, above{28, 18, 7, 2, 1, 1, 1, 1, 1};
        std::array<SymbolModel, SymbolModel::count> models;
        for (std::size_t bits = 0; bits < models.size(); ++bits) {
            SymbolModel::Weights weights{};
            for (std::size_t i = 0; i < weights.size(); ++i)
                weights[i] = i < bits ? below[std::min(bits - i, below.size() - 1)]
                                      : above[std::min(i - bits, above.size() - 1)];
            models[bits] = SymbolModel(weights, seen_before);
        }
        return models;
    }();

    SymbolModel short_, long_;
};

}  // namespace lodestream::codec
