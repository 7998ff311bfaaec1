// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A Modbus RTU server of modbus-serial on a serial device, until it is killed. It prints each register and each coil that
// a request has changed, one a line.   node modbus_serial_server.js FOLDER DEVICE    FOLDER has node_modules
"use strict";
const [folder, device] = process.argv.slice(2);
const {ServerSerial} = require(require.resolve("modbus-serial", {paths: [folder]}));
const {baud, coils, count, first, firstCoil, firstInput, initial, initialBit, inputs, node} = require("./tables.js");

const hex = (value) => value.toString(16).toUpperCase().padStart(4, "0");
const none = {modbusErrorCode: 2, message: "no such address"};
const table = (from, size, value) => new Map(Array.from({length: size}, (_, i) => [from + i, value(from + i)]));
const held = {
    words: table(first, count, initial),
    inputWords: table(first, count, initial),
    coils: table(firstCoil, coils, initialBit),
    inputs: table(firstInput, inputs, initialBit),
};
const get = (from, address) => {
    if (!from.has(address)) throw none;
    return from.get(address);
};
const set = (to, address, value, text) => {
    if (get(to, address) !== value) console.log(text);
    to.set(address, value);
};

new ServerSerial({
    getHoldingRegister: (address) => get(held.words, address),
    getInputRegister: (address) => get(held.inputWords, address),
    getCoil: (address) => get(held.coils, address),
    getDiscreteInput: (address) => get(held.inputs, address),
    setRegister: (address, value) => set(held.words, address, value, `${hex(address)}=${hex(value)}`),
    setCoil: (address, isOn) => set(held.coils, address, isOn, `coil ${hex(address)}=${isOn ? 1 : 0}`),
    readDeviceIdentification: () => ({0: "Interop works", 1: "T-17", 2: "1.0", 4: "Four tables"}),
}, {path: device, baudRate: baud, unitID: node}).on("error", (error) => console.error(error));
