// Text that came from outside made fit to be shown, and numbers as people read them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace lodestream::report {

// Valid UTF-8 without control characters (terminal escapes, line breaks, direction overrides): each becomes U+FFFD.
std::string printable(std::string_view text);

// printable(), with & < > " ' as entities: safe as HTML or SVG text and inside quoted attributes.
std::string escape_html(std::string_view text);

// Columns that a terminal gives the text: two for East Asian wide characters and emoji, none for combining marks.
// pre: printable()
std::size_t terminal_columns(std::string_view utf8);

// As many whole characters from the start as fit into `columns`.
std::string_view terminal_prefix(std::string_view utf8, std::size_t columns);

// A name that is safe as one part of a path: letters, digits, '-', '_' and '.', at most 64, never empty or hidden.
std::string file_stem(std::string_view name);

// "1,234,567"
std::string format_count(std::uint64_t count);

// Three significant digits, from 1000 on grouped and whole: "0.0123", "12.3", "1,235", "1.2e-05". Not finite: "–".
std::string format_number(double value);

// "512 bytes", "12.3 KB", "4.56 MB" (1 KB = 1000 bytes).
std::string format_bytes(double bytes);

// "0.12 ms", "3.4 s".
std::string format_duration(double milliseconds);

std::string base64(std::string_view bytes);

}  // namespace lodestream::report
