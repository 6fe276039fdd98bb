# Recorded dwells under systemd, on a disk of its own: runs of the drive and of an operator, checked, replayed and signed; the
# files under the unit's sandbox; what was altered or removed is found.
. guest/record.sh

start_recorded_rig
claim "record: the folder is the service's, its group may read it" owner_is $folder "dwell:dwell 750"
claim "record: the key is the service's alone" eventually 10 owner_is $folder/key "dwell:dwell 600"
claim "record: an operator cannot read it" may_not as_anna cat $folder/key
claim "record: but its public part" as_anna cat $folder/key.pub
sleep 12

rig_says start
claim "record: a run begins with the drive" eventually 40 run 1 '.state == "recording" and .begun_by == "drive"'
claim "record: every coefficient is within 4 u of the truth" every_coefficient_is_right 8 90
rig_says stop
claim "record: and ends with it" eventually 60 run 1 '.state == "closed" and .dwells == 1'
cp -r $folder "$work/earlier"
rm "$work/earlier/reserve"

claim "record: an operator begins one" as_anna dwellctl start --label "sweep 3" --comment "new damper"
rig_says start
claim "record: every coefficient is right in it" every_coefficient_is_right 8 90
claim "record: the operator ends it" as_anna dwellctl stop
claim "record: it is listed with its label" eventually 20 run 2 '.state == "closed" and .label == "sweep 3" and .begun_by == "operator"'
first=$(file_of 1) second=$(file_of 2)
claim "record: its file is the service's, the group may read it" owner_is "$second" "dwell:dwell 640"
claim "record: show says whose run it was" says "by the operator, anna \(uid [0-9]+\)" as_anna dwellctl show "$second"
claim "record: the drive's holds the 10 s before it" shown "$first" '.dwells[0].start_s >= 10'
claim "record: the clock's state is known, by the kernel's word" \
  shown "$second" '.header.origin | .clock_synchronized == true and .clock_error_s > 0.001 and .clock_error_s < 0.1'
claim "record: both are intact, by the key that the service keeps" says_times 2 ": intact$" as_anna dwellctl audit "$first" "$second" --key $folder/key.pub
claim "record: the ledger knows both" says "ledger: unbroken$" audit "$first" "$second"
claim "record: the replay of the drive's is identical" says "identical: .* bit for bit" as_anna dwellctl replay "$first"
claim "record: the replay of the operator's is identical" says "identical: .* bit for bit" as_anna dwellctl replay "$second"
claim "record: an operator signs" as_anna dwellctl sign "$second" --name "Anna Weber" --meaning reviewed --reason "certificate 2231"
claim "record: the service vouches for her" says "countersigned by the service for user [0-9]+ \(anna\): Anna Weber: reviewed " audit "$second"

# A folder put back to before the second run is whole by itself; the journal holds the heads that were signed since.
journalctl -u dwelld -o short-iso >"$work/journal"
claim "record: the heads in the journal fit" says_times 2 ": intact$" audit "$first" "$second" --anchor "$work/journal"
audit_earlier() { dwellctl audit "$work/earlier/${first##*/}" --ledger "$work/earlier/ledger.dwell-ledger" "$@"; }
claim "record: a folder put back is whole by itself" says "ledger: unbroken" audit_earlier
claim "record: but not beside the journal" refused "anchor" audit_earlier --anchor "$work/journal"

cp -r $folder "$work/copy"
rm "$work/copy/reserve"
copy=$work/copy/${second##*/}
# A bit of an entry. Part of the file belongs to none: of 60 bits flipped at random 14 altered nothing that is read.
flip "$copy" "$(grep -abo "sweep 3" "$copy" | head -n 1 | cut -d : -f 1)"
claim "record: one flipped bit is found" refused "${second##*/}: tampered: " dwellctl audit "$copy"
rm "$work/copy/${first##*/}"
claim "record: a run that was removed is found" refused "missing: run 1 \(${first##*/}" dwellctl audit "$copy" --ledger "$work/copy/ledger.dwell-ledger"
