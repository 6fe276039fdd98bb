# The wall clock is stepped by an hour forth and back and slewed by 500 ppm during a dwell. Samples and reference are
# taken on the raw monotonic clock, so no coefficient may move by more than a tenth of its uncertainty beyond what the
# same data would say: the simulated rig is noise-free here, and its truth is known.
start_rig --tcp 127.0.0.1:1502 --unit mm --noise 0.001
clamped_rig | start_service
coefficients() { dwellctl status --json | jq -c '[.elements[] | .stiffness, .damping | [.value, .u]]'; }
same_within() {  # SHARE FILE FILE: no coefficient differs by more than this share of the first one's u
  jq -se --argjson share "$1" '
    . as [$a, $b] | [range($a | length) | (($a[.][0] - $b[.][0]) / $a[.][1] | fabs)] | max as $worst
    | if $worst <= $share then true else "off by \($worst) u" | halt_error end' "$2" "$3"
}
counted() { dwellctl status --json | jq -e ".state == \"measuring\" and .end_s - .settled_s >= $1"; }

claim "wall clock: a dwell is measured" eventually 60 counted 10
coefficients >"$work/before"
clock-set step 3600
clock-set slew 500
claim "wall clock: the dwell goes on, an hour later and 500 ppm faster" eventually 30 counted 18
clock-set step -7200
clock-set slew -500
claim "wall clock: the dwell goes on, an hour earlier and 500 ppm slower" eventually 30 counted 26
claim "wall clock: it is still the first dwell" sh -c 'dwellctl status --json | jq -e ".index == 1"'
claim "wall clock: every coefficient is within 4 u of the truth" every_coefficient_is_right 28 60
