# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A peer over TCP that responds wrongly: odd_peer.py HEX prints its port, and sends HEX after each request.

In HEX, `nnnn` stands for the number of the request, as Modbus TCP has it. It serves one connection and ends with it.
"""
import socket
import sys


def main():
    listening = socket.create_server(("127.0.0.1", 0))
    print(listening.getsockname()[1], flush=True)
    connection = listening.accept()[0]
    connection.settimeout(20)
    try:
        while request := connection.recv(512):
            connection.sendall(bytes.fromhex(sys.argv[1].replace("nnnn", request[:2].hex())))
    except OSError:
        pass


main()
