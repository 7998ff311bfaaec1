// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#include "cpp_names.hpp"

#include <algorithm>
#include <iterator>

namespace tool::cpp {
namespace {

// Keywords, and macros of the standard library and of systems.
constexpr std::string_view words_of_the_language[] = {
    "alignas",    "alignof",   "and",           "and_eq",
    "asm",        "assert",    "auto",          "bitand",
    "bitor",      "bool",      "break",         "case",
    "catch",      "char",      "char16_t",      "char32_t",
    "char8_t",    "class",     "co_await",      "co_return",
    "co_yield",   "compl",     "concept",       "const",
    "const_cast", "consteval", "constexpr",     "constinit",
    "continue",   "decltype",  "default",       "delete",
    "do",         "double",    "dynamic_cast",  "else",
    "enum",       "EOF",       "errno",         "explicit",
    "export",     "extern",    "false",         "float",
    "for",        "friend",    "goto",          "if",
    "inline",     "int",       "linux",         "long",
    "mutable",    "namespace", "new",           "noexcept",
    "not",        "not_eq",    "NULL",          "nullptr",
    "operator",   "or",        "or_eq",         "private",
    "protected",  "public",    "register",      "reinterpret_cast",
    "requires",   "return",    "short",         "signed",
    "sizeof",     "static",    "static_assert", "static_cast",
    "stderr",     "stdin",     "stdout",        "struct",
    "switch",     "template",  "this",          "thread_local",
    "throw",      "true",      "try",           "typedef",
    "typeid",     "typename",  "union",         "unix",
    "unsigned",   "using",     "virtual",       "void",
    "volatile",   "wchar_t",   "while",         "xor",
    "xor_eq"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_of_name(char c) { return is_digit(c) || is_upper(c) || (c >= 'a' && c <= 'z') || c == '_'; }

// A minus in front of a number. Without it -20 and 20 would have one name.
bool is_sign(std::string_view text, std::size_t i) {
    return text[i] == '-' && (i == 0 || !is_of_name(text[i - 1])) && i + 1 < text.size() &&
           is_digit(text[i + 1]);
}

bool needs_prefix(std::string_view word) {
    if (word.empty() || is_digit(word[0])) return true;
    return word.size() > 1 && word[0] == '_' && (word[1] == '_' || is_upper(word[1]));
}

} // namespace

std::string identifier(std::string_view text, std::string_view prefix) {
    std::string word;
    const auto add = [&](std::string_view part, bool is_apart) {
        if (is_apart && !word.empty()) word += '_';
        word += part;
    };
    bool is_apart = false; // characters that no name has are between
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (is_of_name(text[i])) {
            add(text.substr(i, 1), is_apart);
            is_apart = false;
        } else {
            if (is_sign(text, i)) add("minus", true);
            is_apart = true;
        }
    }
    if (needs_prefix(word)) word.insert(0, prefix);
    if (std::ranges::find(words_of_the_language, std::string_view{word}) != std::end(words_of_the_language))
        word += '_';
    return word;
}

std::string literal(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') quoted += '\\';
        quoted += c;
    }
    return quoted + '"';
}

std::string scope::name(std::string_view text) {
    std::string word = identifier(text, prefix_);
    while (!used_.insert(word).second) word += '_';
    return word;
}

} // namespace tool::cpp
