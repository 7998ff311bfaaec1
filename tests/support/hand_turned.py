# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
"""A device of a file that responds like a ZLAC8015D at rest, and whose positions can be written: a hand that turns its wheels."""

WHEELS = """address,name,type,access,default
0x200D,mode,u16,rw,0
0x20A2,status,u16,ro,0
0x20AB,left_speed,i16,ro,0
0x20AC,right_speed,i16,ro,0
0x2030,left_lines,u16,rw,1024
0x2060,right_lines,u16,rw,4096
0x20A7,left,i32,rw,-1000
0x20A9,right,i32,rw,2147483000
"""
