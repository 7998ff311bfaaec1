// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The example of the Arduino package with a simulated ZLAC8015D: the wheels turn while the switch is closed, and only
// then, also after a restart of the drive. Serial1 is the client's end of a virtual line; its clock is micros().
#include <cstdio>

#include <servobus/sim/line.hpp>
#include <servobus/sim/zlac8015d.hpp>

#include <Arduino.h>

namespace {

servobus::sim::zlac8015d drive;
servobus::sim::station station{drive};
servobus::sim::virtual_line wire_of_test{{.baud = 115200, .poll = servobus::microseconds(20)}};
bool is_closed = false;
bool is_driver_on = false;
bool was_silent = true; // no byte was sent without the RS-485 driver

class uart final : public Stream {
  public:
    void begin(unsigned long) {}
    size_t write(uint8_t byte) override { return write(&byte, 1); }
    size_t write(const uint8_t* data, size_t size) override {
        was_silent = was_silent && is_driver_on;
        return *wire_of_test.send({data, size});
    }
    int availableForWrite() override { return 63; }
    int available() override {
        if (!has_byte_) has_byte_ = *wire_of_test.receive({&byte_, 1}) == 1;
        return has_byte_ ? 1 : 0;
    }
    int read() override {
        if (available() == 0) return -1;
        has_byte_ = false;
        return byte_;
    }
    int peek() override { return available() == 0 ? -1 : byte_; }

  private:
    uint8_t byte_ = 0;
    bool has_byte_ = false;
} Serial1;

} // namespace

unsigned long micros() { return wire_of_test.now().us; }
unsigned long millis() { return micros() / 1000; }
void pinMode(uint8_t, uint8_t) {}
void digitalWrite(uint8_t, uint8_t level) { is_driver_on = level == HIGH; }
int digitalRead(uint8_t) { return is_closed ? LOW : HIGH; }

#include SKETCH

namespace {

bool turns() { return drive.left().speed > 25'000'000 && drive.right().speed < -25'000'000; }
bool rests() { return drive.left().speed == 0 && drive.right().speed == 0; }

/// Runs the loop for so many seconds; each of its iterations must take less than a millisecond. What must hold at the
/// end is checked ten times in the last second.
bool after(unsigned seconds, bool (*holds)(), const char* what) {
    const std::uint64_t end = wire_of_test.time_us() + seconds * 1'000'000ULL;
    std::uint64_t next_check = end - 1'000'000;
    while (wire_of_test.time_us() < end) {
        const std::uint64_t begin = wire_of_test.time_us();
        loop();
        if (wire_of_test.time_us() - begin > 1000)
            return std::printf("an iteration waits: %s\n", what), false;
        if (wire_of_test.time_us() < next_check) continue;
        next_check += 100'000;
        if (!holds()) return std::printf("not so: %s\n", what), false;
    }
    return true;
}

} // namespace

int main() {
    wire_of_test.attach(station);
    setup();
    bool is_right = after(3, rests, "rest before the switch is closed");
    is_closed = true;
    is_right = after(8, turns, "turn when it is closed") && is_right;
    is_closed = false;
    is_right = after(8, rests, "rest when it is open") && is_right;
    is_closed = true;
    is_right = after(8, turns, "turn when it is closed again") && is_right;
    drive.power_cycle();
    is_right = after(20, turns, "turn after a restart of the drive") && is_right;
    wire_of_test.set_connected(0, false);
    is_right = after(10, rests, "rest when the wire is broken: the drive's watchdog") && is_right;
    wire_of_test.set_connected(0, true);
    is_right = after(20, turns, "turn when it is mended") && is_right;
    if (!was_silent) std::printf("a byte was sent without the driver\n");
    return is_right && was_silent ? 0 : 1;
}
