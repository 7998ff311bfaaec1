// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Coolmay C630S AC servo: its alarms, 43 faults and 15 warnings. servobus/device/c630s.hpp includes it.
// Source: manual V24.111, chapter 8; [errata Cn] are in device/errata_c630s.md.
//
// P0D-01 and FunIN.2 reset a warning immediately, and a resettable fault only while the servo is off. For the
// other faults, switch the power off and remove the cause. c630s/advice.hpp has cause and remedy of each.
//
//     const char* why = c630s::text(0x620); // "motor overload", Er.620
//     constexpr const c630s::alarm* a = c630s::find_alarm(0x620);
//     static_assert(a->kind == c630s::alarm_class::fault && a->is_resettable);
#pragma once

#include <cstdint>

#include <servobus/registers/wire.hpp>

namespace servobus::c630s {

/// The table of chapter 8 that an alarm is in. The manual assigns the classes No.1 and No.2 of P02-06 and
/// P02-08 to no code [errata C41].
enum class alarm_class : std::uint8_t { fault, warning };

constexpr const char* text(alarm_class c) { return c == alarm_class::fault ? "fault" : "warning"; }

/// An alarm. The panel shows `code` as "Er." and three hexadecimal digits. P0B-34 presumably holds the same
/// number [errata C17].
struct alarm {
    u16 code;
    alarm_class kind;
    bool is_resettable;
    const char* name;
};

/// All alarms in the manual's order: faults, then warnings, each with its code and name as printed.
// clang-format off
inline constexpr alarm alarms[] = {
    {0x101, alarm_class::fault,   false, "parameter out of range"},                     // Er.101 P02 及以上组参数异常
    {0x102, alarm_class::fault,   false, "programmable logic configuration failed"},    // Er.102 可编程逻辑配置故障
    {0x104, alarm_class::fault,   false, "programmable logic interrupt failed"},        // Er.104 可编程逻辑中断故障
    {0x105, alarm_class::fault,   false, "internal program abnormal"},                  // Er.105 内部程序异常
    {0x108, alarm_class::fault,   false, "parameter storage failed"},                   // Er.108 参数存储故障
    {0x111, alarm_class::fault,   false, "internal fault"},                             // Er.111 内部故障
    {0x120, alarm_class::fault,   false, "product mismatch"},                           // Er.120 产品匹配故障
    {0x121, alarm_class::fault,   true,  "servo on command invalid"},                   // Er.121 伺服 ON 指令无效故障
    {0x122, alarm_class::fault,   false, "product mismatch in absolute position mode"}, // Er.122 绝对位置模式产品匹配故障
    {0x130, alarm_class::fault,   true,  "input function assigned twice"},              // Er.130 DI 功能重复分配
    {0x131, alarm_class::fault,   true,  "output function out of range"},               // Er.131 DO 功能分配超限
    {0x136, alarm_class::fault,   false, "motor rom data invalid"},                     // Er.136 电机 ROM 中数据校验错误或未存入参数
    {0x201, alarm_class::fault,   false, "overcurrent 2"},                              // Er.201 过流 2
    {0x207, alarm_class::fault,   true,  "d/q axis current overflow"},                  // Er.207 D/Q 轴电流溢出故障
    {0x208, alarm_class::fault,   false, "sampling timeout"},                           // Er.208 系统采样运算超时
    {0x210, alarm_class::fault,   false, "output shorted to ground"},                   // Er.210 输出对地短路
    {0x220, alarm_class::fault,   false, "phase sequence wrong"},                       // Er.220 相序错误
    {0x234, alarm_class::fault,   false, "runaway"},                                    // Er.234 飞车
    {0x400, alarm_class::fault,   true,  "main circuit overvoltage"},                   // Er.400 主回路电过压
    {0x410, alarm_class::fault,   true,  "main circuit undervoltage"},                  // Er.410 主回路电欠压
    {0x420, alarm_class::fault,   true,  "main circuit phase loss"},                    // Er.420 主回路电缺相
    {0x430, alarm_class::fault,   true,  "control power undervoltage"},                 // Er.430 控制电欠压
    {0x500, alarm_class::fault,   true,  "overspeed"},                                  // Er.500 超速报警
    {0x510, alarm_class::fault,   true,  "pulse output overspeed"},                     // Er.510 脉冲输出过速
    {0x602, alarm_class::fault,   true,  "angle identification failed"},                // Er.602 角度辨识失败
    {0x610, alarm_class::fault,   true,  "drive overload"},                             // Er.610 驱动器过载
    {0x620, alarm_class::fault,   true,  "motor overload"},                             // Er.620 电机过载
    {0x625, alarm_class::fault,   true,  "brake closed abnormally"},                    // Er.625 抱闸非正常关闭
    {0x626, alarm_class::fault,   true,  "brake opened abnormally"},                    // Er.626 抱闸非正常打开
    {0x630, alarm_class::fault,   true,  "motor stalled"},                              // Er.630 电机堵转
    {0x650, alarm_class::fault,   true,  "heat sink overheated"},                       // Er.650 散热器过热
    {0x731, alarm_class::fault,   true,  "encoder battery failed"},                     // Er.731 编码器电池失效
    {0x733, alarm_class::fault,   true,  "encoder multi-turn count wrong"},             // Er.733 编码器多圈计数错误
    {0x735, alarm_class::fault,   true,  "encoder multi-turn overflow"},                // Er.735 编码器多圈计数溢出
    {0x740, alarm_class::fault,   false, "encoder disturbed"},                          // Er.740 编码器干扰
    {0x834, alarm_class::fault,   true,  "analogue input overvoltage"},                 // Er.834 AD 采样过压
    {0x835, alarm_class::fault,   true,  "analogue sampling disturbed"},                // Er.835 AD 采样故障
    {0xA33, alarm_class::fault,   false, "encoder data abnormal"},                      // Er.A33 编码器数据异常
    {0xA34, alarm_class::fault,   false, "encoder echo check failed"},                  // Er.A34 编码器回送校验异常
    {0xA35, alarm_class::fault,   false, "z signal lost"},                              // Er.A35 Z 信号丢失
    {0xB00, alarm_class::fault,   true,  "following error too large"},               // Er.B00 位置偏差过大
    {0xB01, alarm_class::fault,   true,  "pulse input abnormal"},                       // Er.B01 脉冲输入异常
    {0xB03, alarm_class::fault,   true,  "electronic gear out of range"},               // Er.B03 电子齿轮比设定超限
    {0x110, alarm_class::warning, true,  "divided pulse output setting"},               // Er.110 分频脉冲输出设定故障
    {0x601, alarm_class::warning, true,  "homing failed"},                              // Er.601 回原点失败
    {0x730, alarm_class::warning, true,  "encoder battery warning"},                    // Er.730 编码器电池警告
    {0x831, alarm_class::warning, true,  "analogue zero drift too large"},              // Er.831 AI零漂过大
    {0x900, alarm_class::warning, true,  "emergency stop by input"},                    // Er.900 DI紧急刹车
    {0x909, alarm_class::warning, true,  "motor overload warning"},                     // Er.909 电机过载警告
    {0x920, alarm_class::warning, true,  "braking resistor overload"},                  // Er.920 制动电阻过载
    {0x922, alarm_class::warning, true,  "external braking resistance too small"},      // Er.922 外接制动电阻过小
    {0x939, alarm_class::warning, true,  "motor cable broken"},                         // Er.939 电机动力线断线
    {0x941, alarm_class::warning, true,  "parameter needs a power cycle"},              // Er.941 变更参数需重新上电生效
    {0x942, alarm_class::warning, true,  "parameters stored too often"},                // Er.942 参数存储频繁
    {0x950, alarm_class::warning, true,  "positive overtravel"},                        // Er.950 正向超程警告
    {0x952, alarm_class::warning, true,  "negative overtravel"},                        // Er.952 反向超程警告
    {0x980, alarm_class::warning, true,  "internal encoder fault"},                     // Er.980 编码器内部故障
    {0xA40, alarm_class::warning, true,  "internal fault in self-learning"},            // Er.A40 内部故障
};
// clang-format on

/// Finds the alarm with a code such as 0x101; null if the manual has no such alarm.
constexpr const alarm* find_alarm(u16 code) {
    for (const alarm& a : alarms) {
        if (a.code == code) return &a;
    }
    return nullptr;
}

constexpr const char* text(const alarm& a) { return a.name; }
/// The name of the alarm with a code such as 0x101, as P0B-34 presumably holds it [errata C17]; 0 is none.
constexpr const char* text(u16 code) {
    const alarm* const a = find_alarm(code);
    if (a != nullptr) return a->name;
    return code == 0 ? "none" : "unlisted alarm";
}

} // namespace servobus::c630s
