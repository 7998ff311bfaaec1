// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// Repeats the description of a hardware that the framework reads from the URDF (hardware_interface 2.54.0, Humble).
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

namespace hardware_interface {

struct InterfaceInfo {
    std::string name;
    std::string min;
    std::string max;
    std::string initial_value;
    std::string data_type;
    int size;
};

struct ComponentInfo {
    std::string name;
    std::string type;
    std::vector<InterfaceInfo> command_interfaces;
    std::vector<InterfaceInfo> state_interfaces;
    std::unordered_map<std::string, std::string> parameters;
};

struct JointInfo {
    std::string name;
    std::vector<std::string> state_interfaces;
    std::vector<std::string> command_interfaces;
    std::string role;
    double mechanical_reduction = 1.0;
    double offset = 0.0;
};

struct ActuatorInfo {
    std::string name;
    std::vector<std::string> state_interfaces;
    std::vector<std::string> command_interfaces;
    std::string role;
    double mechanical_reduction = 1.0;
    double offset = 0.0;
};

struct TransmissionInfo {
    std::string name;
    std::string type;
    std::vector<JointInfo> joints;
    std::vector<ActuatorInfo> actuators;
    std::unordered_map<std::string, std::string> parameters;
};

struct HardwareInfo {
    std::string name;
    std::string type;
    std::string hardware_class_type;
    std::unordered_map<std::string, std::string> hardware_parameters;
    std::vector<ComponentInfo> joints;
    std::vector<ComponentInfo> sensors;
    std::vector<ComponentInfo> gpios;
    std::vector<TransmissionInfo> transmissions;
    std::string original_xml;
};

} // namespace hardware_interface
