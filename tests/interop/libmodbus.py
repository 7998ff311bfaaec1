# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""servobus' client and server against libmodbus' server and client, over pseudo-terminals."""
from peers import build, folder, has_libmodbus, need_peer, ran
from checks import begin, check, end, expect, expect_same, finish, text_of, until


def holds_what_was_written(server, client):
    """The lines of the registers that were written, each and no other."""
    written, held = (set(text_of(notes).split("\n")) - {""} for notes in (client, server))
    expect(written, "nothing was written")
    expect_same(sorted(written), sorted(held))


need_peer(has_libmodbus, "libmodbus-dev")
need_peer("socat", "socat")
libmodbus_server, libmodbus_client = build("libmodbus_server", "-lmodbus"), build("libmodbus_client", "-lmodbus")
own_client, own_server, same_responses = build("own_client"), build("own_server"), build("same_responses")
near, far, own, written, held = (folder / name for name in ("near", "far", "own", "written", "held"))
line = begin("socat", f"pty,raw,echo=0,link={near}", f"pty,raw,echo=0,link={far}")
until(lambda: near.exists() and far.exists(), line, "the line")


def begin_own():
    server = begin(own_server, own, out=held)
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
print("# the same requests to both servers")
begin(libmodbus_server, far)
begin_own()
ran(same_responses, own, near)
finish()
