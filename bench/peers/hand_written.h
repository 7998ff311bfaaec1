// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// What an embedded engineer writes by hand for one drive, in C: requests of functions 03, 06 and 10h, a
// 256-entry CRC table, a transaction over three callbacks with a timeout, and the usual checks (length,
// CRC, address, function, byte count or echoed register address). The cost of the library is compared with
// it, so it does nothing unnecessary. It keeps none of the library's promises: no gap before a request, no
// protection against late or doubled responses or those of other nodes, no time limit with a stopped clock,
// no retry.
#ifndef SERVOBUS_BENCH_HAND_WRITTEN_H
#define SERVOBUS_BENCH_HAND_WRITTEN_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    hw_ok,
    hw_send_failed,
    hw_timeout,
    hw_bad_crc,
    hw_wrong_node,
    hw_wrong_function,
    hw_wrong_length,
    hw_wrong_echo,
    hw_exception
} hw_status;

typedef struct {
    void* wire;
    size_t (*send)(void* wire, const uint8_t* bytes, size_t count);
    size_t (*receive)(void* wire, uint8_t* bytes, size_t room);
    uint32_t (*now)(void* wire);
    uint32_t timeout;
} hw_port;

// clang-format off
static const uint16_t hw_crc_table[256] = {
    0x0000, 0xC0C1, 0xC181, 0x0140, 0xC301, 0x03C0, 0x0280, 0xC241, 0xC601, 0x06C0, 0x0780, 0xC741,
    0x0500, 0xC5C1, 0xC481, 0x0440, 0xCC01, 0x0CC0, 0x0D80, 0xCD41, 0x0F00, 0xCFC1, 0xCE81, 0x0E40,
    0x0A00, 0xCAC1, 0xCB81, 0x0B40, 0xC901, 0x09C0, 0x0880, 0xC841, 0xD801, 0x18C0, 0x1980, 0xD941,
    0x1B00, 0xDBC1, 0xDA81, 0x1A40, 0x1E00, 0xDEC1, 0xDF81, 0x1F40, 0xDD01, 0x1DC0, 0x1C80, 0xDC41,
    0x1400, 0xD4C1, 0xD581, 0x1540, 0xD701, 0x17C0, 0x1680, 0xD641, 0xD201, 0x12C0, 0x1380, 0xD341,
    0x1100, 0xD1C1, 0xD081, 0x1040, 0xF001, 0x30C0, 0x3180, 0xF141, 0x3300, 0xF3C1, 0xF281, 0x3240,
    0x3600, 0xF6C1, 0xF781, 0x3740, 0xF501, 0x35C0, 0x3480, 0xF441, 0x3C00, 0xFCC1, 0xFD81, 0x3D40,
    0xFF01, 0x3FC0, 0x3E80, 0xFE41, 0xFA01, 0x3AC0, 0x3B80, 0xFB41, 0x3900, 0xF9C1, 0xF881, 0x3840,
    0x2800, 0xE8C1, 0xE981, 0x2940, 0xEB01, 0x2BC0, 0x2A80, 0xEA41, 0xEE01, 0x2EC0, 0x2F80, 0xEF41,
    0x2D00, 0xEDC1, 0xEC81, 0x2C40, 0xE401, 0x24C0, 0x2580, 0xE541, 0x2700, 0xE7C1, 0xE681, 0x2640,
    0x2200, 0xE2C1, 0xE381, 0x2340, 0xE101, 0x21C0, 0x2080, 0xE041, 0xA001, 0x60C0, 0x6180, 0xA141,
    0x6300, 0xA3C1, 0xA281, 0x6240, 0x6600, 0xA6C1, 0xA781, 0x6740, 0xA501, 0x65C0, 0x6480, 0xA441,
    0x6C00, 0xACC1, 0xAD81, 0x6D40, 0xAF01, 0x6FC0, 0x6E80, 0xAE41, 0xAA01, 0x6AC0, 0x6B80, 0xAB41,
    0x6900, 0xA9C1, 0xA881, 0x6840, 0x7800, 0xB8C1, 0xB981, 0x7940, 0xBB01, 0x7BC0, 0x7A80, 0xBA41,
    0xBE01, 0x7EC0, 0x7F80, 0xBF41, 0x7D00, 0xBDC1, 0xBC81, 0x7C40, 0xB401, 0x74C0, 0x7580, 0xB541,
    0x7700, 0xB7C1, 0xB681, 0x7640, 0x7200, 0xB2C1, 0xB381, 0x7340, 0xB101, 0x71C0, 0x7080, 0xB041,
    0x5000, 0x90C1, 0x9181, 0x5140, 0x9301, 0x53C0, 0x5280, 0x9241, 0x9601, 0x56C0, 0x5780, 0x9741,
    0x5500, 0x95C1, 0x9481, 0x5440, 0x9C01, 0x5CC0, 0x5D80, 0x9D41, 0x5F00, 0x9FC1, 0x9E81, 0x5E40,
    0x5A00, 0x9AC1, 0x9B81, 0x5B40, 0x9901, 0x59C0, 0x5880, 0x9841, 0x8801, 0x48C0, 0x4980, 0x8941,
    0x4B00, 0x8BC1, 0x8A81, 0x4A40, 0x4E00, 0x8EC1, 0x8F81, 0x4F40, 0x8D01, 0x4DC0, 0x4C80, 0x8C41,
    0x4400, 0x84C1, 0x8581, 0x4540, 0x8701, 0x47C0, 0x4680, 0x8641, 0x8201, 0x42C0, 0x4380, 0x8341,
    0x4100, 0x81C1, 0x8081, 0x4040
};
// clang-format on

static inline uint16_t hw_crc16(const uint8_t* bytes, size_t count) {
    uint16_t crc = 0xFFFF;
    for (size_t i = 0; i < count; i++) crc = (uint16_t)((crc >> 8) ^ hw_crc_table[(crc ^ bytes[i]) & 0xFF]);
    return crc;
}

static inline void hw_put_word(uint8_t* to, uint16_t word) {
    to[0] = (uint8_t)(word >> 8);
    to[1] = (uint8_t)(word & 0xFF);
}

static inline uint16_t hw_word(const uint8_t* from) { return (uint16_t)((from[0] << 8) | from[1]); }

// Puts the CRC after `count` bytes and returns the length of the frame.
static inline size_t hw_close(uint8_t* frame, size_t count) {
    const uint16_t crc = hw_crc16(frame, count);
    frame[count] = (uint8_t)(crc & 0xFF);
    frame[count + 1] = (uint8_t)(crc >> 8);
    return count + 2;
}

static inline size_t hw_build_read(uint8_t* frame, uint8_t node, uint16_t address, uint16_t quantity) {
    if (quantity < 1 || quantity > 125) return 0;
    frame[0] = node;
    frame[1] = 0x03;
    hw_put_word(frame + 2, address);
    hw_put_word(frame + 4, quantity);
    return hw_close(frame, 6);
}

static inline size_t hw_build_write(uint8_t* frame, uint8_t node, uint16_t address, uint16_t value) {
    frame[0] = node;
    frame[1] = 0x06;
    hw_put_word(frame + 2, address);
    hw_put_word(frame + 4, value);
    return hw_close(frame, 6);
}

static inline size_t hw_build_write_many(uint8_t* frame, uint8_t node, uint16_t address,
                                         const uint16_t* values, uint16_t quantity) {
    if (quantity < 1 || quantity > 123) return 0;
    frame[0] = node;
    frame[1] = 0x10;
    hw_put_word(frame + 2, address);
    hw_put_word(frame + 4, quantity);
    frame[6] = (uint8_t)(2 * quantity);
    for (uint16_t i = 0; i < quantity; i++) hw_put_word(frame + 7 + 2 * i, values[i]);
    return hw_close(frame, (size_t)(7 + 2 * quantity));
}

// Checks what every response must have: at least 5 bytes, a valid CRC, this address, this function.
static inline hw_status hw_check(const uint8_t* response, size_t count, uint8_t node, uint8_t function) {
    if (count < 5) return hw_wrong_length;
    if (hw_crc16(response, count - 2) != (response[count - 2] | (response[count - 1] << 8))) return hw_bad_crc;
    if (response[0] != node) return hw_wrong_node;
    if (response[1] == (function | 0x80)) return hw_exception;
    return response[1] == function ? hw_ok : hw_wrong_function;
}

static inline hw_status hw_parse_read(const uint8_t* response, size_t count, uint8_t node, uint16_t* words,
                                      uint16_t quantity) {
    const hw_status status = hw_check(response, count, node, 0x03);
    if (status != hw_ok) return status;
    if (response[2] != 2 * quantity || count != (size_t)(5 + 2 * quantity)) return hw_wrong_length;
    for (uint16_t i = 0; i < quantity; i++) words[i] = hw_word(response + 3 + 2 * i);
    return hw_ok;
}

static inline hw_status hw_parse_write(const uint8_t* response, size_t count, const uint8_t* request) {
    const hw_status status = hw_check(response, count, request[0], request[1]);
    if (status != hw_ok) return status;
    if (count != 8) return hw_wrong_length;
    for (int i = 2; i < 6; i++) {
        if (response[i] != request[i]) return hw_wrong_echo;
    }
    return hw_ok;
}

// Sends the request and collects the response: `expected` bytes, or five for an exception. `got` is how
// many came.
static inline hw_status hw_exchange(const hw_port* port, const uint8_t* request, size_t count, uint8_t* response,
                                    size_t expected, size_t* got) {
    if (port->send(port->wire, request, count) != count) return hw_send_failed;
    const uint32_t start = port->now(port->wire);
    size_t have = 0;
    while (have < expected) {
        const size_t came = port->receive(port->wire, response + have, expected - have);
        have += came;
        if (have >= 2 && (response[1] & 0x80) != 0) expected = 5;
        if (came == 0 && port->now(port->wire) - start > port->timeout) return hw_timeout;
    }
    *got = have;
    return hw_ok;
}

static inline hw_status hw_read(const hw_port* port, uint8_t node, uint16_t address, uint16_t* words,
                                uint16_t quantity) {
    uint8_t request[8];
    uint8_t response[256];
    size_t got = 0;
    const size_t count = hw_build_read(request, node, address, quantity);
    if (count == 0) return hw_wrong_length;
    const hw_status status = hw_exchange(port, request, count, response, (size_t)(5 + 2 * quantity), &got);
    return status == hw_ok ? hw_parse_read(response, got, node, words, quantity) : status;
}

static inline hw_status hw_write(const hw_port* port, uint8_t node, uint16_t address, uint16_t value) {
    uint8_t request[8];
    uint8_t response[8];
    size_t got = 0;
    const size_t count = hw_build_write(request, node, address, value);
    const hw_status status = hw_exchange(port, request, count, response, 8, &got);
    return status == hw_ok ? hw_parse_write(response, got, request) : status;
}

static inline hw_status hw_write_many(const hw_port* port, uint8_t node, uint16_t address,
                                      const uint16_t* values, uint16_t quantity) {
    uint8_t request[256];
    uint8_t response[8];
    size_t got = 0;
    const size_t count = hw_build_write_many(request, node, address, values, quantity);
    if (count == 0) return hw_wrong_length;
    const hw_status status = hw_exchange(port, request, count, response, 8, &got);
    return status == hw_ok ? hw_parse_write(response, got, request) : status;
}

#endif
