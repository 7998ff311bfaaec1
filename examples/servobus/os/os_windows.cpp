// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifdef _WIN32

#include "os.hpp"

#include <iterator>
#include <system_error>

#include "../../host.hpp"
#include "interrupts.hpp"

namespace tool {

void interrupts::arm() { ::host::watch_for_interruptions(); }
bool interrupts::came() { return ::host::is_interrupted(); }

namespace os {

// In the words of the other systems, where the C++ library knows them.
std::string error_text(int error) {
    const std::error_condition known = std::system_category().default_error_condition(error);
    if (known.category() == std::generic_category()) return known.message();
    wchar_t words[512]{};
    const DWORD size =
        ::FormatMessageW(FORMAT_MESSAGE_FROM_SYSTEM | FORMAT_MESSAGE_IGNORE_INSERTS, nullptr,
                         static_cast<DWORD>(error), 0, words, static_cast<DWORD>(std::size(words)), nullptr);
    std::string text(4 * std::size(words), '\0'); // UTF-8, as records are
    const int bytes = ::WideCharToMultiByte(CP_UTF8, 0, words, static_cast<int>(size), text.data(),
                                            static_cast<int>(text.size()), nullptr, nullptr);
    text.resize(static_cast<std::size_t>(bytes));
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r' || text.back() == '.'))
        text.pop_back();
    return text.empty() ? "error " + std::to_string(error) + " of Windows" : text;
}
// Access is denied where another program has the port; `in_use_text` says so.
std::string advice_on_access(const char*) { return {}; }
std::string resolve_error_text(int error) { return error_text(error); }

std::string set_rs485(native::serial_settings& settings, std::string_view how) {
    if (how != "on")
        return "--rs485 takes on, not '" + std::string{how} +
               "': the adapter's driver has polarity and delays";
    settings.rs485 = true;
    return {};
}

} // namespace os
} // namespace tool

#endif
