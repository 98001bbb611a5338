"""What each command does, without the shell: functions from named input to frozen objects.

    request = Request(times={"stop": "10"}, overrides={"l": "2"})
    motion = read_motion(content, "pendulum.yaml", request)             # motion: system, values, settings
    solved = solve(motion, find_target("pendulum.h5", force=True), request)          # solve: how it ended
    swept = sweep(make_ensemble(spec, members, request), target, request)            # ensemble, sweep
    found = classify(spec)                                              # check: what kind of system it is
    ranking = rank_methods(spec, values, None, 1e-9, entries, rules)    # bench: time against error
    derived = derive(spec)                                              # equations: to be read

The comments name the modules. Nothing here prints, exits or reads options: stages, progress, messages and
interrupts reach whoever has asked through a ``Monitor``.
"""
