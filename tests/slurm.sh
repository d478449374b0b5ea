#!/usr/bin/env bash
# slurm.sh [ONEIRO]: a sweep as a job array of a real Slurm, whose daemons run for it on loopback. Tasks are stopped by
# their time budget, signalled, requeued, cancelled and killed, and the controller is killed too: the tables must be
# those of one process, byte for byte. If Slurm isn't installed, Debian's packages are unpacked into the target folder;
# the system isn't changed, and root isn't needed.
set -euo pipefail
cd "$(dirname "$0")/.."
. tests/own-apt.sh

target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
oneiro=$(realpath "${1:-$target/debug/oneiro}")
slurm=$target/debian-slurm
export PATH=$slurm/root/usr/bin:$slurm/root/usr/sbin:$PATH:/usr/sbin

say() { printf '\n== Slurm: %s\n' "$*"; }
fail() {
    echo "$*" >&2
    exit 1
}

has_slurm() {
    local tool
    for tool in munged slurmctld slurmd slurmstepd sbatch scancel scontrol squeue; do
        command -v $tool >/dev/null || return
    done
}

get_slurm() {
    local file
    say "getting Debian's packages"
    rm -rf "$slurm"
    mkdir -p "$slurm/root"
    # Installed packages aren't fetched again.
    cp /var/lib/dpkg/status "$slurm/status" || fail "this is no Debian: please install Slurm and munge"
    own_apt "$slurm" || fail "Debian's package lists can't be had"
    apt-get install -q -y --download-only --no-install-recommends slurmctld slurmd slurm-client munge >/dev/null ||
        fail "Debian's packages of Slurm can't be had"
    for file in "$slurm"/cache/archives/*.deb; do
        dpkg -x "$file" "$slurm/root"
    done
    for file in "$slurm"/root/usr/sbin/*-wlm; do
        [ ! -e "$file" ] || ln -s "${file##*/}" "${file%-wlm}"
    done
    rm -rf "$slurm"/{lists,cache}
}

has_slurm || get_slurm
# Empty if the system's own are used.
plugins=$(find "$slurm/root/usr/lib" -name auth_munge.so -printf %h 2>/dev/null || true)
[ -z "$plugins" ] || export LD_LIBRARY_PATH=$plugins:${plugins%/*}

work=$(mktemp -d)
export SLURM_CONF=$work/slurm.conf
began=$SECONDS

# Daemons, tasks and programs, even if they have been reparented: they all have this variable.
processes() { grep -lsz "^SLURM_CONF=$SLURM_CONF\$" /proc/[0-9]*/environ | cut -d/ -f3; }

clean_up() {
    local code=$? file
    if [ $code != 0 ]; then
        squeue --states=all --array || true
        for file in "$work"/*.log; do
            printf '\n-- %s\n' "$file"
            tail -n 40 "$file"
        done
    fi >&2
    # From here on the shell would only report its kills, and its own processes must not be mistaken for tasks.
    exec 2>/dev/null
    export -n SLURM_CONF
    while processes | xargs -r kill -KILL; [ "$(processes)" ]; do sleep 0.1; done
    rm -rf "$work"
    exit $code
}
trap clean_up EXIT
trap 'exit 1' HUP INT TERM

# Ports that are probably free, and differ from those of another such test running at the same time.
port=$((20000 + $$ % 10000 * 2))
mkdir "$work"/{state,spool}
echo "CgroupPlugin=cgroup/v1" >"$work/cgroup.conf"
cat >"$SLURM_CONF" <<END
ClusterName=oneiro
SlurmctldHost=$(uname -n | cut -d. -f1)(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
# A requeued task waits until its previous credential expires: by default two minutes, at least 5 s.
AuthInfo=socket=$work/munge.socket,cred_expire=5
${plugins:+PluginDir=$plugins}
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
MailProg=/bin/true
# A container may lack control groups.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=sched_interval=1,bf_interval=1
# Possibly more processors than there are, so that all tasks run at the same time.
SlurmdParameters=config_overrides
NodeName=node NodeAddr=127.0.0.1 CPUs=8
PartitionName=all Nodes=node Default=YES
END
(umask 077 && head -c 1024 /dev/urandom >"$work/munge.key")
# By force, because no other user can enter its folder.
munged --foreground --force --key-file="$work/munge.key" --socket="$work/munge.socket" --pid-file="$work/munge.pid" \
    --seed-file="$work/munge.seed" &>"$work/munged.log" &
start_controller() {
    slurmctld -D &>>"$work/slurmctld.log" &
    controller=$!
}
start_controller
slurmd -D -N node -d "$(command -v slurmstepd)" &>"$work/slurmd.log" &

# within SECONDS COMMAND...: waits until it succeeds.
within() {
    local end=$((SECONDS + $1))
    until "${@:2}" &>/dev/null; do
        [ $SECONDS -lt $end ] || fail "not within $1 s: ${*:2}"
        sleep 0.1
    done
}
# The states of tasks 1 to 4, whether a task is working, and its program.
are() { [ "$(squeue --noheader --states=all --array --format="%K %T" --job="$job" | sort | cut -d' ' -f2 | xargs)" = "$*" ]; }
shard() { echo "sweep run $work/sweep.toml .*--shard $1/4( |\$)"; }
program() { pgrep -f "$(shard "$1")"; }
# Its program then holds the lock of its shard.
at_work() {
    local lock
    scontrol show job "${job}_$1" | grep JobState=RUNNING && program "$1" &&
        lock=$(stat -c %i "array/shard-$1-of-4/lock") && grep ":$lock " /proc/locks
}
signal_all() { pkill "$1" -f "$(shard .)"; }
digests() { (cd "$1" && sha256sum results.csv generations.csv); }
content() { find "$work/array" -type f -exec sha256sum {} + | sort; }

cat >"$work/sweep.toml" <<END
name = "slurm"
experiment = "$PWD/experiments/khepera-avoidance.toml"
seeds = "1..12"
[set]
evolution.generations = 1000
[grid]
noise.sensor = [[0.0, 0.0], [0.0, 0.4]]
evolution.population = [20, 100]
END
cd "$work"
sweep=("$oneiro" sweep run "$work/sweep.toml" --backend cpu)

say "the sweep in one process"
before=${EPOCHREALTIME/[.,]/}
"${sweep[@]}" --threads 4 --out reference --quiet
# At most a third of the time of a task with one thread, so that each is stopped; and no more than 3 s, because the
# machine may have been busier for this measurement than it will be for the tasks.
budget=$(((${EPOCHREALTIME/[.,]/} - before) / 3))
budget=$(printf '%07d' $((budget < 3000000 ? budget : 3000000)))
budget=${budget::-6}.${budget: -6:3}s

say "the sweep in four tasks, $budget at a time"
"${sweep[@]}" --threads 1 --out "$work/array" --checkpoint-every 0.2s --shards 4 --time-budget "$budget" --print-slurm >array.sh
within 20 scontrol ping
job=$(sbatch --parsable array.sh)
# Each is paused as soon as it works: its time may be over before another one begins.
hold() { at_work "$1" && pkill -STOP -f "$(shard "$1")"; }
holds=()
for task in 1 2 3 4; do
    within 60 hold $task &
    holds+=($!)
done
for hold in "${holds[@]}"; do wait "$hold"; done

say "another process for task 1's shard is refused and changes nothing"
sleep 0.2
before=$(content)
code=0
"${sweep[@]}" --out "$work/array" --shard 1/4 || code=$?
[ $code = 75 ] || fail "it ended with $code"
[ "$(content)" = "$before" ] || fail "it changed files"

say "task 1 is requeued, 2 cancelled, 3 killed, 4 told to stop"
# Waiting tasks aren't restarted before all four have been seen.
scontrol update PartitionName=all State=DOWN
scontrol requeue "${job}_1"
scancel "${job}_2"
kill -KILL "$(program 3)"
scancel --signal=TERM --batch "${job}_4"
signal_all -CONT
within 60 are PENDING CANCELLED FAILED PENDING
scontrol requeue "${job}_2,${job}_3"
scontrol update PartitionName=all State=UP

say "the controller is killed; the next one requeues by itself what ends with 75"
within 60 at_work 3
# The controller saves its state some seconds after a change. A task whose start was not saved would be started twice, and
# Slurm would then hold the task and close the node. So no task may start now, and a change makes the controller save.
scontrol update PartitionName=all State=DOWN
signal_all -STOP
touch mark
scontrol update JobId="$job" Comment=saved
within 20 [ state/job_state -nt mark ]
{ kill -KILL $controller && wait $controller; } 2>/dev/null || true
signal_all -CONT
echo "RequeueExit=75" >>"$SLURM_CONF"
start_controller

say "all tasks end"
within 240 are COMPLETED COMPLETED COMPLETED COMPLETED
stops=$(cat slurm-*.log | grep -c "is queued again" || true)
[ "$stops" -ge 2 ] || fail "no task was stopped by its time budget"
"$oneiro" sweep merge array --out merged
[ "$(digests merged)" = "$(digests reference)" ] || fail "the tables differ from those of one process"
sed -i '$s/[0-9]/x/' merged/results.csv
[ "$(digests merged)" != "$(digests reference)" ] || fail "tables that differ would not be noticed"

say "one program and the controller killed, one task cancelled, $stops stopped by themselves," \
    "$(grep -c Requeuing slurmctld.log) requeued: the same tables, in $((SECONDS - began)) s"
