# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus' client and server against libmodbus' server and client, over pseudo-terminals."""
from peers import begin_line, build, folder, has_libmodbus, holds_what_was_written, need_peer, ran
from checks import begin, check, end, finish, until


need_peer(has_libmodbus, "libmodbus-dev")
need_peer("socat", "socat")
libmodbus_server, libmodbus_client = build("libmodbus_server", "-lmodbus"), build("libmodbus_client", "-lmodbus")
libmodbus_tables_client = build("libmodbus_tables_client", "-lmodbus")
own_client, own_server, same_responses = build("own_client"), build("own_server"), build("same_responses")
tables_client, tables_server = build("tables_client"), build("tables_server")
own, written, held = (folder / name for name in ("own", "written", "held"))
near, far = begin_line()


def begin_own(program=own_server):
    own.unlink(missing_ok=True)
    server = begin(program, own, out=held)
    until(own.exists, server, "our server")
    return server


print("# our client, libmodbus' server")
server = begin(libmodbus_server, far, out=held)
ran(own_client, near, written)
check("libmodbus' server holds what servobus' client wrote", holds_what_was_written, held, written)
end(server)
print("# libmodbus' client, our server")
server = begin_own()
ran(libmodbus_client, own, written)
check("servobus' server holds what libmodbus' client wrote", holds_what_was_written, held, written)
end(server)
print("# our client with rows of all tables, libmodbus' server")
server = begin(libmodbus_server, far, out=held)
ran(tables_client, near, written, "16", "17", "11")
check("libmodbus' server holds what servobus' rows wrote", holds_what_was_written, held, written)
end(server)
print("# libmodbus' client, our server of rows")
server = begin_own(tables_server)
ran(libmodbus_tables_client, own, written)
check("servobus' rows hold what libmodbus' client wrote", holds_what_was_written, held, written)
end(server)
print("# the same requests to both servers")
begin(libmodbus_server, far)
begin_own()
ran(same_responses, own, near)
finish()
