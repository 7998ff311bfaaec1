// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
#ifndef _WIN32

#include "os.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <optional>

#include <netdb.h>

#include "../../posix_access.hpp"
#include "../words/numbers.hpp"
#include "interrupts.hpp"

namespace tool {
namespace {

volatile std::sig_atomic_t interruption = 0;

} // namespace

void interrupts::arm() {
    struct sigaction act {};
    act.sa_handler = [](int) { interruption = 1; };
    (void)::sigaction(SIGINT, &act, nullptr);
    (void)::sigaction(SIGTERM, &act, nullptr);
}
bool interrupts::came() { return interruption != 0; }

namespace os {

std::string error_text(int error) { return std::strerror(error); }
std::string advice_on_access(const char* path) { return host::advice_on_access(path); }
std::string resolve_error_text(int error) { return ::gai_strerror(error); }

std::string set_rs485(native::serial_settings& settings, std::string_view how) {
    using servobus::posix::rs485_driver;
    using servobus::posix::rs485_polarity;
    const std::string shown{how};
    const auto next = [&how] {
        const std::string_view part = how.substr(0, how.find(','));
        how.remove_prefix(std::min(part.size() + 1, how.size()));
        return part;
    };
    const std::string_view polarity = next();
    rs485_driver driver{};
    if (polarity == "rts-on-send")
        driver.polarity = rs485_polarity::rts_on_send;
    else if (polarity == "rts-after-send")
        driver.polarity = rs485_polarity::rts_after_send;
    bool is_right = polarity == "on" || driver.polarity != rs485_polarity::as_configured;
    for (servobus::duration* const delay : {&driver.before_send, &driver.after_send}) {
        if (how.empty()) break;
        const std::optional<std::int64_t> ms = parse_integer(next());
        is_right = is_right && ms && *ms >= 0 && *ms <= 1000;
        if (is_right) *delay = servobus::milliseconds(static_cast<std::uint32_t>(*ms));
    }
    if (!is_right || !how.empty() || shown.ends_with(','))
        return "--rs485 takes on, rts-on-send or rts-after-send, with ,BEFORE,AFTER in ms (0..1000), not '" +
               shown + "'";
    settings.rs485 = true;
    settings.driver = driver;
    return {};
}

} // namespace os
} // namespace tool

#endif
