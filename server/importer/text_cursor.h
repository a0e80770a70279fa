// Walks the words and numbers of a text format. Lines end at \n, \r\n or \r; a comment runs to the end of its line.
#pragma once

#include <cctype>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <span>
#include <string>
#include <string_view>

namespace lodestream::importer {

inline std::string_view as_text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return lower;
}

// The number that `word` is from its first to its last character; NaN where it is none.
inline double parse_number(std::string_view word) {
    if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size() || word.empty()) return std::numeric_limits<double>::quiet_NaN();
    // Out of double's range: strtod tells too large (infinity) from too small (zero).
    if (error == std::errc::result_out_of_range) return std::strtod(std::string(word).c_str(), nullptr);
    return error == std::errc{} ? value : std::numeric_limits<double>::quiet_NaN();
}

class TextCursor {
  public:
    explicit TextCursor(std::string_view text, char comment = '\0')
        : at_(text.data()), end_(text.data() + text.size()), comment_(comment) {}

    std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

    // True where no word is left on this line.
    bool at_line_end() {
        while (at_ < end_ && is_blank(*at_)) ++at_;
        return at_ == end_ || is_line_end(*at_) || is_comment();
    }

    void skip_line() {
        while (at_ < end_ && !is_line_end(*at_)) ++at_;
        if (at_ < end_) at_ += (*at_ == '\r' && at_ + 1 < end_ && at_[1] == '\n') ? 2 : 1;
    }

    // Moves to the next word, over blanks, line ends and comments; false where the text ends first.
    bool find_word() {
        while (at_line_end()) {
            if (at_ == end_) return false;
            skip_line();
        }
        return true;
    }

    // The next word of this line; empty at its end.
    std::string_view word() {
        if (at_line_end()) return {};
        const char* begin = at_;
        while (at_ < end_ && !is_blank(*at_) && !is_line_end(*at_)) ++at_;
        return {begin, static_cast<std::size_t>(at_ - begin)};
    }

    // The next word of this line as a number; NaN where there is none.
    double number() {
        if (at_line_end()) return std::numeric_limits<double>::quiet_NaN();
        double value = 0;
        const auto [end, error] = std::from_chars(at_, end_, value);
        if (error == std::errc{} && (end == end_ || is_blank(*end) || is_line_end(*end))) {
            at_ = end;
            return value;
        }
        return parse_number(word());
    }

    // What is left of this line without blanks at its ends, and moves to the next line.
    std::string_view rest_of_line() {
        at_line_end();
        const char* begin = at_;
        while (at_ < end_ && !is_line_end(*at_)) ++at_;
        const char* last = at_;
        while (last > begin && is_blank(last[-1])) --last;
        skip_line();
        return {begin, static_cast<std::size_t>(last - begin)};
    }

  private:
    static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }
    static bool is_line_end(char c) { return c == '\n' || c == '\r'; }
    bool is_comment() const { return comment_ != '\0' && *at_ == comment_; }

    const char* at_;
    const char* end_;
    char comment_;
};

}  // namespace lodestream::importer
