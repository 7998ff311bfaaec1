// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "row_words.hpp"

#include <bit>
#include <charconv>
#include <cmath>

#include <servobus/registers/value_text.hpp>

#include "../words/numbers.hpp"

namespace tool {
namespace {

using servobus::entry;

// Texts of 123 registers, each character written as \x0A.
constexpr std::size_t longest_text = 1024;

template <class Put> std::string text_by(Put put) {
    char room[longest_text];
    servobus::text_writer text{room};
    put(text);
    return {room, text.size()};
}

template <class Float> std::optional<Float> finite_number(std::string_view text) {
    Float value = 0;
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc{} || stopped != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

// `1.5e3` times ten to the power of -`exponent`.
std::optional<std::string> with_exponent(std::string_view text, int exponent) {
    if (exponent == 0) return std::string{text};
    const std::size_t at = std::min(text.find_first_of("eE"), text.size());
    std::string_view own = text.substr(std::min(at + 1, text.size()));
    if (own.starts_with('+')) own.remove_prefix(1);
    const std::optional<std::int64_t> given = own.empty() ? 0 : parse_integer(own);
    if (!given || (own.empty() && at != text.size()) || *given > 9999 || *given < -9999) return std::nullopt;
    return std::string{text.substr(0, at)} + 'e' + std::to_string(*given - exponent);
}

std::optional<std::uint64_t> float_of(const entry& e, std::string_view text) {
    if (e.kind == servobus::value_kind::float_pair) {
        const std::optional<float> value = finite_number<float>(text);
        return value ? std::optional<std::uint64_t>{std::bit_cast<u32>(*value)} : std::nullopt;
    }
    const std::optional<double> value = finite_number<double>(text);
    return value ? std::optional{std::bit_cast<std::uint64_t>(*value)} : std::nullopt;
}

} // namespace

std::vector<u16> words_of_bits(const entry& row, std::uint64_t bits) {
    if (row.is_part()) bits <<= row.form->first_bit;
    std::vector<u16> words(row.words());
    for (std::size_t i = words.size(); i-- != 0; bits >>= 16) words[i] = static_cast<u16>(bits & 0xFFFFu);
    return words;
}

std::vector<u16> words_of(const entry& row, std::int64_t number) {
    if (row.kind == servobus::value_kind::float_pair)
        return words_of_bits(row, std::bit_cast<u32>(static_cast<float>(number)));
    if (row.kind == servobus::value_kind::float_quad)
        return words_of_bits(row, std::bit_cast<std::uint64_t>(static_cast<double>(number)));
    return words_of_bits(row, bits_of_number(row, number).bits);
}

servobus::row_value value_of_words(const entry& row, std::span<const u16> words) {
    return value_of(row, bits_of_words(row, words));
}

std::int64_t number_of(const entry& row, std::span<const u16> words) {
    return value_of_words(row, words).count();
}

bool takes_words(const entry& row, std::span<const u16> words) {
    return is_text(row) || takes(row, value_of_words(row, words));
}

std::string words_text(const entry& row, std::span<const u16> words, const servobus::row_scale& scale,
                       const char* scaled_by) {
    return text_by([&](servobus::text_writer& out) {
        put_row(out, row, words, servobus::value_format::tokens, scale, scaled_by);
        if (has(row.flags, servobus::flag::scaled_elsewhere)) out << servobus::factory_scale_note;
    });
}
std::string words_text(const entry& row, std::span<const u16> words) {
    return words_text(row, words, unknown_scale(row));
}
std::string number_text(const entry& row, std::int64_t number) {
    return words_text(row, words_of(row, number));
}

std::string plain_text(const entry& row, std::span<const u16> words) {
    return text_by([&](servobus::text_writer& out) {
        if (is_text(row)) return put_text(out, row, words, true);
        servobus::entry plain = row;
        plain.unit_of_count = {};
        const servobus::row_value v = value_of_words(row, words);
        const bool has_digits =
            v.is == servobus::row_value::state::number || v.is == servobus::row_value::state::real;
        if (has_digits) return put_number(out, plain, v);
        out << "0x";
        for (const u16 word : words_of_bits(row, v.bits)) out.hex(word, 4);
    });
}

std::optional<std::vector<u16>> parse_plain(const entry& row, std::string_view text) {
    if (is_text(row)) {
        const bool is_quoted = text.size() > 1 && text.starts_with('"') && text.ends_with('"');
        return is_quoted ? parse_text(row, text) : std::nullopt;
    }
    if (is_float(row)) {
        const std::optional<std::uint64_t> bits = float_of(row, text);
        return bits ? std::optional{words_of_bits(row, *bits)} : std::nullopt;
    }
    const bool is_negative = text.starts_with('-');
    const std::optional<std::uint64_t> size = parse_magnitude(text.substr(is_negative ? 1 : 0));
    if (!size) return std::nullopt;
    const servobus::number_bits found = bits_of_number(row, is_negative, *size);
    return found.fits ? std::optional{words_of_bits(row, found.bits)} : std::nullopt;
}

std::optional<std::uint64_t> parse_float(const entry& row, std::string_view text) {
    const servobus::detail::power_of_ten scale = servobus::detail::power_of(row.unit_of_count);
    if (!scale.is_one) return std::nullopt;
    const std::optional<std::string> raw = with_exponent(text, scale.exponent);
    return raw ? float_of(row, *raw) : std::nullopt;
}

std::optional<std::vector<u16>> parse_text(const entry& row, std::string_view text) {
    if (text.size() > 1 && text.starts_with('"') && text.ends_with('"'))
        text = text.substr(1, text.size() - 2);
    std::vector<u16> words(row.words());
    std::size_t size = 0;
    while (!text.empty()) {
        auto byte = static_cast<unsigned char>(text[0]);
        std::size_t taken = 1;
        if (byte == '\\') {
            taken = 4;
            const std::optional<std::uint64_t> code =
                text.size() >= taken && text[1] == 'x'
                    ? parse_magnitude("0x" + std::string{text.substr(2, 2)})
                    : std::nullopt;
            if (!code) return std::nullopt;
            byte = static_cast<unsigned char>(*code);
        }
        if (size == 2 * words.size()) return std::nullopt;
        words[size / 2] = static_cast<u16>(words[size / 2] | (size % 2 == 0 ? byte << 8 : byte));
        ++size;
        text.remove_prefix(taken);
    }
    return words;
}

} // namespace tool
