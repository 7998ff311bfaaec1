# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A peer over TCP that responds wrongly."""
import socket
import threading
from contextlib import contextmanager


@contextmanager
def odd_peer(response: str):
    """Sends these bytes after each request, on one connection; gives its port.

    In the response, `nnnn` stands for the number of the request, as Modbus TCP has it.
    """
    server = socket.create_server(("127.0.0.1", 0))

    def serve():
        try:
            with server.accept()[0] as connection:
                while request := connection.recv(512):
                    connection.sendall(bytes.fromhex(response.replace("nnnn", request[:2].hex())))
        except OSError:  # the client, or the test, has ended
            pass

    threading.Thread(target=serve, daemon=True).start()
    with server:
        yield server.getsockname()[1]
