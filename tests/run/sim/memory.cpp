// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The register memory for simulated drives (sim/memory.hpp), as the author of one uses it: a pump with a setting that
// is kept, a target that is not, and a status that is never written. It is a register store of a station.
#include <cstddef>
#include <cstdint>
#include <span>

#include <doctest/doctest.h>

#include <servobus/core/bytes.hpp>
#include <servobus/core/slice.hpp>
#include <servobus/modbus/server.hpp>
#include <servobus/registers/catalogue.hpp>
#include <servobus/sim/memory.hpp>

namespace memory_tests {

using namespace servobus;

namespace {

struct pump {
    static constexpr profile facts{.name = "pump"};
};
inline constexpr reg<u16, access::rw, pump> ramp{0x0010, {0, 500}, no_unit, 200, saved};
inline constexpr reg<i32, access::rw, pump> level{0x0012, full<i32>, no_unit, -5};
inline constexpr reg<u16, access::ro, pump> status{0x0015, full<u16>, no_unit, 0};

inline constexpr auto rows =
    in_address_order(list("ramp", ramp), list("level", level), list("status", status));
inline constexpr sim::register_index<0x0010, 8> index_of_rows{std::span<const entry>{rows}};

/// The memory of the pump: what its manual says of power-on and of a save.
class pump_memory : public sim::register_memory<0x0010, 8> {
  public:
    pump_memory() : register_memory{index_of_rows} {
        (void)fill_eeprom(&is_saved);
        power_on();
    }
    void power_on() {
        clear();
        fill([](const entry&) { return true; });
        recall(&is_saved);
    }
    void save() { keep(&is_saved); }

  private:
    static bool is_saved(const entry& e) { return e.address == ramp.address; }
};

/// What a station calls.
struct simulated_pump {
    pump_memory memory{};

    std::uint8_t read(std::uint16_t address, slice<std::uint16_t> to) const {
        for (std::size_t i = 0; i < to.size(); ++i) {
            if (!index_of_rows.covers(static_cast<std::uint16_t>(address + i))) return 2;
        }
        for (std::size_t i = 0; i < to.size(); ++i) to[i] = memory[static_cast<std::uint16_t>(address + i)];
        return 0;
    }
    std::uint8_t write(std::uint16_t address, words_view from) {
        for (std::size_t i = 0; i < from.size(); ++i) {
            const auto at = static_cast<std::uint16_t>(address + i);
            if (!index_of_rows.covers(at) || index_of_rows.row(at).rights == access::ro) return 2;
        }
        for (std::size_t i = 0; i < from.size(); ++i) {
            const auto at = static_cast<std::uint16_t>(address + i);
            memory.set(at, from[i]);
            memory.note(at, from[i]);
        }
        return 0;
    }
};
static_assert(modbus::register_store<simulated_pump>);

std::uint8_t write(simulated_pump& m, std::uint16_t address, std::uint16_t value) {
    const std::uint8_t word[]{static_cast<std::uint8_t>(value >> 8),
                              static_cast<std::uint8_t>(value & 0xFFu)};
    return m.write(address, words_view{word});
}

} // namespace

TEST_CASE("an index knows which addresses exist, and their rows") {
    constexpr std::uint16_t existing[]{0x0010, 0x0012, 0x0013, 0x0015};
    constexpr std::uint16_t missing[]{0x0000, 0x000F, 0x0011, 0x0014, 0x0016, 0x0018, 0xFFFF};
    for (const std::uint16_t address : existing) CHECK(index_of_rows.covers(address));
    for (const std::uint16_t address : missing) CHECK_FALSE(index_of_rows.covers(address));
    CHECK(index_of_rows.row(0x0013).address == level.address);
    CHECK(index_of_rows.rows().size() == 3);
}

TEST_CASE("a memory has the defaults of its rows, and a restart loses what is not kept") {
    simulated_pump device;
    pump_memory& m = device.memory;
    CHECK(m[ramp.address] == 200);
    CHECK(m.pair(level.address) == -5);
    CHECK(write(device, ramp.address, 300) == 0);
    m.set_pair(level.address, 70'000);
    CHECK(m[0x0012] == 1);
    m.power_on();
    CHECK(m[ramp.address] == 200);
    CHECK(m.pair(level.address) == -5);
    CHECK(write(device, ramp.address, 300) == 0);
    m.save();
    CHECK(m.saves() == 1);
    CHECK(m.eeprom_writes() == 1);
    m.power_on();
    CHECK(m[ramp.address] == 300);
}

TEST_CASE("a memory counts and logs the words that a client writes") {
    simulated_pump device;
    pump_memory& m = device.memory;
    CHECK(write(device, status.address, 1) == 2);
    CHECK(write(device, 0x0011, 1) == 2);
    CHECK(m.writes() == 0);
    CHECK(m.write(0).ordinal == 0);
    for (std::uint16_t i = 0; i < 100; ++i) CHECK(write(device, ramp.address, i) == 0);
    CHECK(m.writes() == 100);
    CHECK(m.writes_to(ramp.address) == 100);
    CHECK(m.writes_to(level.address) == 0);
    CHECK(m.writes_to(0xFFFF) == 0);
    CHECK(m.write(0).value == 99);
    CHECK(m.write(63).value == 36);
    CHECK(m.write(64).ordinal == 0);
}

} // namespace memory_tests
