# What the scenarios of the wall clock share, with a rig and a service that run: the clock is stepped by an hour forth and back
# and slewed by 500 ppm during a dwell. What a slew would do to the data shows in the frequency first: c goes with its
# square, so a frequency that is right to 50 ppm says that less than 100 ppm of any c, less than 0.1 u here, is the wall
# clock's.
# The rig needs a noise well above that of the guest's scheduling, so that it is the same throughout.
# $of: what the claims begin with
coefficients() { dwellctl status --json | jq -c '[.elements[] | .stiffness, .damping | [.value, .u]]'; }
counted() {  # SECONDS
  dwellctl status --json | jq -e ".state == \"measuring\" and .index == ${index:-.index} and .end_s - .settled_s >= $1"
}
frequency_is_right() {
  dwellctl status --json | jq -e '(.frequency_hz.value / 4 - 1) * 1e6 | if fabs < 50 then true else "off by \(.) ppm" | halt_error end'
}
# More data make the same dwell's estimate better; it may move by what that explains, three times the root of the
# difference of the variances, and 0.1 u.
same_but_better() {
  jq -se 'def off($a; $b): (($a[0] - $b[0]) | fabs) / (0.1 * $a[1] + 3 * ((($a[1] * $a[1] - $b[1] * $b[1]) | fabs) | sqrt));
    . as [$a, $b] | [range($a | length) | off($a[.]; $b[.])] | max
    | if . <= 1 then true else "off by \(.) of what is allowed: \($a), then \($b)" | halt_error end' "$work/before" "$work/after"
}

claim "$of: a dwell is measured" eventually 120 counted 8
index=$(dwellctl status --json | jq .index)
coefficients >"$work/before"
clock-set step 3600
clock-set slew 500
claim "$of: the same dwell goes on, an hour later and 500 ppm faster" eventually 90 counted 16
claim "$of: its frequency is that of the rig" frequency_is_right
clock-set step -7200
clock-set slew -500
claim "$of: the same dwell goes on, an hour earlier and 500 ppm slower" eventually 90 counted 24
claim "$of: its frequency is still that of the rig" frequency_is_right
coefficients >"$work/after"
claim "$of: no coefficient has moved" same_but_better
claim "$of: every coefficient is within 4 u of the truth" every_coefficient_is_right 24 60
clock-set step 3600
clock-set slew 0
