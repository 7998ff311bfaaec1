// SPDX-FileCopyrightText: The servobus authors
// SPDX-License-Identifier: BSL-1.0
//
// A client of modbus-serial with the library's server of rows, on a serial device. It notes what it changes in a file, a
// register or a coil a line.   node modbus_serial_client.js FOLDER DEVICE FILE    FOLDER has node_modules
"use strict";
const fs = require("fs");
const [folder, device, file] = process.argv.slice(2);
const ModbusRTU = require(require.resolve("modbus-serial", {paths: [folder]}));
const {baud, coils, first, firstCoil, firstInput, initial, initialBit, inputs, node} = require("./tables.js");

const client = new ModbusRTU();
let notes = "";
let failed = 0;

function check(name, holds) {
    failed += holds ? 0 : 1;
    console.log(`${holds ? "ok     " : "FAILED "} ${name}`);
}
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const hex = (value) => value.toString(16).toUpperCase().padStart(4, "0");
const list = (count, from) => Array.from({length: count}, (_, i) => from(i));
const words = async (address, count) => (await client.readHoldingRegisters(address, count)).data;
const bits = async (count) => (await client.readCoils(firstCoil, count)).data.slice(0, count);

async function isRefused(call, number) {
    try {
        await call;
    } catch (error) {
        return error.modbusCode === number;
    }
    return false;
}

async function reads() {
    for (const count of [1, 8, 9, coils])
        check(`modbus-serial reads by 01 ${count}`, same(await bits(count), list(count, (i) => initialBit(firstCoil + i))));
    for (const count of [1, 8, inputs])
        check(`modbus-serial reads by 02 ${count}`,
              same((await client.readDiscreteInputs(firstInput, count)).data.slice(0, count),
                   list(count, (i) => initialBit(firstInput + i))));
    for (const count of [1, 125]) {
        const expected = list(count, (i) => initial(first + i));
        check(`modbus-serial reads by 03 ${count}`, same(await words(first, count), expected));
        check(`modbus-serial reads by 04 ${count}`,
              same((await client.readInputRegisters(first, count)).data, expected));
    }
}

async function exceptions() {
    check("01: exception 2", await isRefused(client.readCoils(firstCoil + coils, 1), 2));
    check("02: exception 2", await isRefused(client.readDiscreteInputs(firstInput + inputs - 1, 2), 2));
    check("05: exception 2", await isRefused(client.writeCoil(0, true), 2));
    check("06: exception 2", await isRefused(client.writeRegister(0x3000, 1), 2));
    check("10h: exception 2", await isRefused(client.writeRegisters(0x3000, [1, 2]), 2));
}

// Neither 16h nor 17h, whose responses its port for RTU does not receive, nor 11h, which it does not end.
async function writes() {
    for (const isOn of [true, false]) {
        await client.writeCoil(firstCoil, isOn);
        check(`modbus-serial writes by 05 ${isOn}`, same(await bits(1), [isOn]));
        notes += `coil ${hex(firstCoil)}=${isOn ? 1 : 0}\n`;
    }
    const wanted = list(coils, (i) => i % 2 === 1);
    await client.writeCoils(firstCoil, wanted);
    check(`modbus-serial writes by 0F ${coils}`, same(await bits(coils), wanted));
    wanted.forEach((isOn, i) => {
        if (isOn !== initialBit(firstCoil + i)) notes += `coil ${hex(firstCoil + i)}=${isOn ? 1 : 0}\n`;
    });
    await client.writeRegister(first + 20, 0x5A14);
    check("modbus-serial writes by 06", same(await words(first + 20, 1), [0x5A14]));
    notes += "2014=5A14\n";
    const many = list(123, (i) => 0x3C00 + i);
    await client.writeRegisters(first + 60, many);
    check("modbus-serial writes by 10h 123", same(await words(first + 60, 123), many));
    many.forEach((word, i) => { notes += `${hex(first + 60 + i)}=${hex(word)}\n`; });
}

async function describes() {
    const basic = JSON.stringify(await client.readDeviceIdentification(1, 0));
    check(`modbus-serial reads the identification by 2Bh/0Eh, code 1: ${basic}`,
          ["Interop works", "T-17", "1.0"].every((text) => basic.includes(`"${text}"`)));
}

async function main() {
    await client.connectRTUBuffered(device, {baudRate: baud});
    client.setID(node);
    client.setTimeout(5000);
    await reads();
    await exceptions();
    await writes();
    await describes();
    fs.writeFileSync(file, notes);
}

setTimeout(() => { check("it ends within 40 s", false); process.exit(1); }, 40000).unref();
main().catch((error) => check(`no error: ${error.stack || error}`, false)).then(() => process.exit(failed ? 1 : 0));
