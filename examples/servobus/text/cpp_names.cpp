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

} // namespace

std::string identifier(std::string_view text) {
    std::string word{text};
    for (char& c : word) {
        const bool is_good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        if (!is_good) c = '_';
    }
    if (word[0] >= '0' && word[0] <= '9') word.insert(0, "device_");
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
    std::string word = identifier(text);
    while (!used_.insert(word).second) word += '_';
    return word;
}

} // namespace tool::cpp
