//! Another user of the same host can neither mislead heft, nor read its data, nor block it.
//!
//! Needs root, to act as both users, and a separate shared memory for the tests; skips elsewhere.

mod common;

use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use common::both;

/// The group of an operator's display.
const GROUP: u32 = 61_234;

/// Runs `script` with its own `/dev/shm`, with `foe` as a command that runs a line as another user, `friend` as one of [`GROUP`],
/// and `heft`, `OUT` (a new folder writable by all) set. `None`, with a message, if that is not possible.
fn with_a_foe(script: &str) -> Option<Output> {
    let folder = tempfile::tempdir().expect("a folder");
    let open = std::os::unix::fs::PermissionsExt::from_mode(0o777);
    std::fs::set_permissions(folder.path(), open).expect("its mode");
    let copy = folder.path().join("heft");
    std::fs::copy(env!("CARGO_BIN_EXE_heft"), &copy).expect("a binary that all may run");
    let script = format!(
        "mount -t tmpfs -o mode=1777 tmpfs /dev/shm || exit 99
         setpriv --reuid=65534 --regid=65534 --clear-groups true || exit 99
         unset XDG_RUNTIME_DIR
         heft={}; OUT={}; cd $OUT
         foe() {{ setpriv --reuid=65534 --regid=65534 --clear-groups sh -c \"$1\"; }}
         friend() {{ setpriv --reuid=65533 --regid=65533 --groups={GROUP} sh -c \"$1\"; }}
         {script}",
        copy.display(),
        folder.path().display()
    );
    let mut may = Command::new("unshare");
    let allowed = may.args(["--mount", "true"]).status();
    let is_allowed = allowed.is_ok_and(|status| status.success());
    let output = Command::new("unshare")
        .args(["--mount", "sh", "-c", &script])
        .output();
    match output {
        Ok(output) if output.status.code() != Some(99) && is_allowed => Some(output),
        _ => {
            let _ = writeln!(
                std::io::stderr(),
                "skipped: this user cannot play another one"
            );
            None
        }
    }
}

fn passes(script: &str) {
    if let Some(output) = with_a_foe(script) {
        assert!(
            output.status.success(),
            "{}\n{}",
            output.status,
            both(&output)
        );
    }
}

const RUN: &str = "run excavator --quiet --no-report";

#[test]
fn links_and_folders_of_others_are_neither_followed_nor_emptied() {
    passes(&format!(
        "mkdir victim; touch victim/precious
         foe \"mkdir /dev/shm/heft; ln -s $OUT/victim /dev/shm/heft/a1\"
         $heft {RUN} --duration 1 --out one || exit 1
         $heft doctor --clean
         test -f victim/precious && test -L /dev/shm/heft/a1 || exit 2
         rm -r /dev/shm/heft; foe \"ln -s $OUT /dev/shm/heft\"
         $heft {RUN} --duration 1 --out two || exit 3
         test -f victim/precious || exit 4"
    ));
}

#[test]
fn a_home_that_another_user_made_is_not_used_and_stops_no_run() {
    passes(&format!(
        "mkdir -m 700 victim; touch victim/precious
         foe \"ln -s $OUT/victim /dev/shm/heft-0\"
         $heft {RUN} --duration 1 --out one || exit 1
         test \"$(ls victim)\" = precious || exit 2
         rm /dev/shm/heft-0; foe 'mkdir -m 777 /dev/shm/heft-0'
         $heft {RUN} --duration 1 --out two || exit 3
         test -z \"$(ls /dev/shm/heft-0)\" || exit 6
         $heft doctor --clean
         test -f victim/precious && test -d /dev/shm/heft-0 || exit 4
         mkdir -m 700 own; mount -t tmpfs -o mode=700 tmpfs own
         XDG_RUNTIME_DIR=$OUT/own $heft {RUN} --duration 1 --out three || exit 5"
    ));
}

#[test]
fn nothing_of_a_run_is_open_to_another_user() {
    passes(&format!(
        "$heft {RUN} --duration 3 --out out --domain d > said 2>&1 & sleep 2
         find /dev/shm -mindepth 1 ! -path '*/root/*' -perm /077 > open
         find out -perm /077 >> open
         test -s open && {{ xargs ls -ld < open; exit 1; }}
         ls /dev/shm/*global_mgmt > /dev/null || exit 2
         foe 'for f in /dev/shm/heft-0.*; do truncate -s 0 $f && exit 1; cat $f && exit 1; done; ls /dev/shm/heft-0 && exit 1; true' 2> /dev/null || exit 3
         foe \"$heft doctor; $heft top --once\" | grep 'run .d.' && exit 4
         pkill -KILL --parent $! -f 'service kalman'
         wait $!; cat said
         grep -q 'kalman died' said || exit 5"
    ));
}

#[test]
fn two_users_run_side_by_side() {
    passes(&format!(
        "$heft {RUN} --duration 3 --out out & sleep 0.3
         foe \"$heft {RUN} --duration 1 --out theirs\" || exit 1
         foe \"$heft {RUN} --duration 1 --out theirs2 2>&1\" | grep removed && exit 2
         wait $! || exit 3"
    ));
}

#[test]
fn a_domain_that_was_left_behind_is_removed_without_what_is_not_its_own() {
    passes(&format!(
        "mkdir victim; touch victim/precious
         $heft {RUN} --duration 60 --out out --domain left & sleep 1.5; kill -KILL $!; sleep 2
         ln -s $OUT/victim /dev/shm/heft-0/left/root/link
         touch /dev/shm/heft-0/left/unknown
         $heft {RUN} --duration 1 --out two || exit 1
         test -f victim/precious || exit 2
         test -f /dev/shm/heft-0/left/unknown || exit 3
         rm /dev/shm/heft-0/left/unknown; $heft doctor --clean
         test -e /dev/shm/heft-0/left && exit 4
         ls /dev/shm | grep 'heft-0.left' && exit 5; true"
    ));
}

#[test]
fn a_recording_is_for_its_user_alone() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let run = "run excavator --duration 0.5 --quiet --out";
    let mut args: Vec<&str> = run.split(' ').collect();
    args.push(out.to_str().expect("a path"));
    common::run_ok(&args);
    let mode = |path: &Path| path.metadata().expect("made").permissions().mode() & 0o777;
    assert_eq!(mode(&out), 0o700);
    for file in ["run.mcap", "report.html"] {
        assert_eq!(mode(&out.join(file)), 0o600, "{file}");
    }
}

#[test]
fn what_a_listener_makes_is_closed_to_others_too() {
    passes(&format!(
        "umask 022
         $heft {RUN} --duration 8 --domain listened --out one & run=$!
         sleep 3
         $heft tail --domain listened > rows 2> said & tail=$!
         sleep 2
         open=$(find /dev/shm -type f -perm /066)
         kill $tail; wait $run
         test -s rows || {{ echo 'nothing was heard'; cat said; exit 1; }}
         test -z \"$open\" || {{ echo \"open: $open\"; exit 2; }}"
    ));
}

#[test]
fn a_group_that_is_named_reads_and_follows_the_run_and_can_do_nothing_else_to_it() {
    passes(&format!(
        "mkdir -m 777 theirs
         $heft {RUN} --duration 14 --split 2s --out out --domain shown --group {GROUP} > said 2>&1 & run=$!
         sleep 3
         window=$(echo /dev/shm/heft-0.shown.*.window)
         test \"$(stat -c '%a %g' $window)\" = '640 {GROUP}' || {{ ls -l /dev/shm; exit 1; }}
         test \"$(stat -c '%a %g' out)\" = '750 {GROUP}' || exit 2
         friend \"timeout 3 $heft tail --domain shown --format csv\" > rows 2> whose
         grep -q 'shown of user 0' whose || {{ cat whose; exit 3; }}
         test $(wc -l < rows) -gt 150 || {{ cat rows whose; exit 4; }}
         friend \"$heft top --once\" | grep -q kg || exit 5
         friend \"$heft export $OUT/out -o $OUT/theirs/csv\" || exit 6
         test $(wc -l < theirs/csv/excavator_sensors.csv) -gt 300 || {{ ls theirs/csv; exit 7; }}
         echo 'for f in '$window' out out/*; do
                 (: >> $f) && echo wrote $f
                 truncate -s 0 $f && echo shortened $f
                 rm -r $f && echo removed $f
               done
               touch out/new && echo made
               for f in /dev/shm/heft-0.*; do test $f = '$window' && continue; cat $f && echo read $f; done
               ls /dev/shm/heft-0 && echo looked
               for p in $(pgrep -P '$run'); do kill -0 $p && echo signalled; done
               flock -n '$window' true && echo locked' > attempts
         friend \". $OUT/attempts\" > done 2> refused
         test -s done && {{ cat done; exit 8; }}
         foe \". $OUT/attempts; cat $window out/*; ls out; $heft tail --domain shown\" > done 2> refused
         test -s done && {{ cat done; exit 9; }}
         open=$(find /dev/shm -type f -perm /077 ! -name '*.window')
         test -z \"$open\" || {{ echo $open; exit 10; }}
         wait $run || {{ cat said; exit 11; }}
         find out -type f ! -perm 640 -o -perm /007 | grep . && exit 12
         test ! -e $window || exit 13"
    ));
}

#[test]
fn a_group_is_one_that_exists_and_that_the_user_is_in() {
    passes(&format!(
        "$heft {RUN} --duration 1 --out one --group nobody-has-this > said 2>&1; test $? = 2 || exit 1
         grep -q nobody-has-this said && grep -q 'what to do' said || exit 2
         foe \"$heft {RUN} --duration 1 --out two --group {GROUP}\" > said 2>&1; test $? = 2 || exit 3
         grep -q SupplementaryGroups said || {{ cat said; exit 4; }}
         friend \"cd theirs 2> /dev/null; $heft {RUN} --duration 1 --out $OUT/three --group {GROUP}\" || exit 5"
    ));
}

#[test]
fn a_display_believes_no_window_that_is_not_made_for_its_group() {
    passes(
        "foe 'echo heft window 1 excavator > /dev/shm/heft-65534.fake.1.window; chmod 644 /dev/shm/heft-65534.fake.1.window
              mkfifo -m 644 /dev/shm/heft-65534.pipe.1.window'
         friend \"timeout 5 $heft tail --domain fake\" > said 2>&1; test $? = 2 || exit 1
         grep -q 'no pipeline runs' said || { cat said; exit 2; }",
    );
}

/// The number of root's processes is not limited.
#[test]
fn a_limit_of_too_few_processes_is_reported() {
    passes(
        "printf 't,swing_velocity,swing_torque\\n0,.1,9\\n' > day.csv; chmod a+r day.csv
         for most in 1 2 8 11 14; do
             for what in 'estimate day.csv --machine excavator -o day.out' 'run excavator --duration .3 -q --out run'; do
                 foe \"exec prlimit --nproc=$most $heft $what\" > said 2>&1; status=$?
                 case $status in 0|1|2) ;; *) echo \"$most: $what: $status\"; cat said; exit 1 ;; esac
                 if grep panicked said; then exit 1; fi
             done
         done",
    );
}
