# SPDX-FileCopyrightText: The servobus authors
# SPDX-License-Identifier: BSL-1.0
#
# Part of tests/tool.sh: the names that a complaint suggests. Those expected are by hand, what a person would say is
# meant.
# shellcheck shell=sh

complains() { # LINE ARGUMENTS...: this line and no other
    line="servobus: $1"
    shift
    run "$@"
    check "$line" [ "$status" = 2 -a "$(cat "$dir/err")" = "$line" -a ! -s "$dir/out" ]
}
complains "unknown command 'raed'; did you mean read?" raed
complains "unknown command 'watsh'; did you mean watch?" watsh
complains "unknown command 'MAP'; did you mean map?" MAP
complains "unknown command 'back'; did you mean backup?" back
complains "unknown command 'fly'; see servobus --help" fly
complains "unknown command ''; see servobus --help" ""
complains "unknown command '_'; see servobus --help" _
complains "unknown option '--jsno'; did you mean --json?" read --jsno
complains "unknown option '--dryrun'; did you mean --dry-run?" restore --dryrun
complains "unknown option '--node'; did you mean --nodes?" scan --node=3
complains "unknown option '-yes'; did you mean --yes?" write -yes
complains "unknown option '--colour'; see servobus map --help" map --colour
complains "unknown device 'zlac8015'; did you mean zlac8015d?" map zlac8015
complains "unknown device 'c360s'; did you mean c630s?" map c360s
complains "unknown device 'yako'; did you mean yako-open-loop or yako-closed-loop?" map yako
complains "unknown device 'yako_closed_loop'; did you mean yako-closed-loop?" read p yako_closed_loop:1 x
complains "unknown device 'servo'; known: zlac8015d, yako-closed-loop, yako-open-loop, c630s" map servo
reads() { # LINE REG
    complains "zlac8015d has no register '$2'$1" read p zlac8015d "$2"
}
reads "; did you mean bus_voltage?" bus_volt
reads "; did you mean bus_voltage?" bus_votlage
reads "; did you mean bus_voltage?" Bus-Voltage
reads "; did you mean left_max_current?" left_max_curren
reads "; did you mean left_max_current?" lef_max_curent
reads "; did you mean left_max_current or right_max_current?" max_current
reads "; did you mean left_max_speed, left_start_speed or left_target_speed?" left_speed
reads "; did you mean left_actual_speed or right_actual_speed?" actual_speed
reads "; did you mean left_actual_torque or right_actual_torque?" torque_actual
reads "; servobus map zlac8015d lists them" voltmeter
reads "; servobus map zlac8015d lists them" 0x3000
reads "; servobus map zlac8015d lists them" ""
long=$(printf '%0200d' 0)
reads "; servobus map zlac8015d lists them" "$long"
complains "c630s has no register 'jog_sped'; did you mean jog_speed?" write p c630s jog_sped=5
complains "control_word: 'quikstop' is none of its names; did you mean quick_stop?" \
    write p zlac8015d control_word=quikstop
complains "input_polarity: 'x0+x11' is none of its names; did you mean x1?" \
    write p yako-closed-loop input_polarity=x0+x11
complains "homing_method: 'up' is none of $("$tool" write p yako-open-loop homing_method=up 2>&1 | sed 's/.*none of //')" \
    write p yako-open-loop homing_method=up
check "and its names follow" err_has "negative_limit"
