// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// The macros that an Arduino sketch has before its own includes, as spelled in the AVR core's Arduino.h and
// in the headers that it includes. Where the body of a macro needs names of the core, it is `poison` here,
// so that a header that expands the macro does not compile.
#pragma once

#include <math.h> // Arduino.h also includes these four before its macros
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define HIGH 0x1
#define LOW 0x0
#define INPUT 0x0
#define OUTPUT 0x1
#define INPUT_PULLUP 0x2
#define PI 3.1415926535897932384626433832795
#define HALF_PI 1.5707963267948966192313216916398
#define TWO_PI 6.283185307179586476925286766559
#define DEG_TO_RAD 0.017453292519943295769236907684886
#define RAD_TO_DEG 57.295779513082320876798154814105
#define EULER 2.718281828459045235360287471352
#define SERIAL 0x0
#define DISPLAY 0x1
#define LSBFIRST 0
#define MSBFIRST 1
#define CHANGE 1
#define FALLING 2
#define RISING 3
#define DEFAULT 1
#define EXTERNAL 0
#define INTERNAL 3
#define INTERNAL1V1 2

#undef abs
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define abs(x) ((x) > 0 ? (x) : -(x))
#define constrain(amt, low, high) ((amt) < (low) ? (low) : ((amt) > (high) ? (high) : (amt)))
#define round(x) ((x) >= 0 ? (long)((x) + 0.5) : (long)((x)-0.5))
#define radians(deg) ((deg)*DEG_TO_RAD)
#define degrees(rad) ((rad)*RAD_TO_DEG)
#define sq(x) ((x) * (x))
#define interrupts() poison()
#define noInterrupts() poison()
#define clockCyclesPerMicrosecond() poison()
#define clockCyclesToMicroseconds(a) poison(a)
#define microsecondsToClockCycles(a) poison(a)
#define lowByte(w) ((uint8_t)((w)&0xff))
#define highByte(w) ((uint8_t)((w) >> 8))
#define bitRead(value, bit) (((value) >> (bit)) & 0x01)
#define bitSet(value, bit) ((value) |= (1UL << (bit)))
#define bitClear(value, bit) ((value) &= ~(1UL << (bit)))
#define bitToggle(value, bit) ((value) ^= (1UL << (bit)))
#define bitWrite(value, bit, bitvalue) ((bitvalue) ? bitSet(value, bit) : bitClear(value, bit))
#define bit(b) (1UL << (b))
#define word(...) makeWord(__VA_ARGS__)
#define analogInPinToBit(P) (P)
#define digitalPinToPort(P) poison(P)
#define digitalPinToTimer(P) poison(P)
#define NOT_A_PIN 0
#define NOT_A_PORT 0
#define NOT_AN_INTERRUPT -1
#define NOT_ON_TIMER 0
#define PA 1
#define PB 2
#define PC 3
#define PD 4
#define PE 5
#define PF 6
#define PG 7
#define PH 8
#define PJ 10
#define PK 11
#define PL 12
#define TIMER0A 1
#define TIMER1A 3
#define TIMER2 6
#define DEC 10
#define HEX 16
#define OCT 8
#define BIN 2
#define F(string_literal) poison(string_literal)
#define PSTR(s) poison(s)
#define PROGMEM poison
#define B0 0
#define B1 1
#define B00 0
#define B01 1
#define B10 2
#define B11 3
#define B000 0
#define B00000000 0
#define B11111111 255
#define cli() poison()
#define sei() poison()
#define SERIAL_8N1 0x06
#define SERIAL_8E1 0x26
#define SERIAL_8N2 0x0E
#define SERIAL_8O1 0x36
#define _BV(bit) (1 << (bit))
