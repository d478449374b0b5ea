#!/bin/bash
# The sweep "{name}" in {shards} shards, each a task of a job array: give this file to sbatch, with what your cluster
# asks for besides, such as --partition, --account or --mem. A task whose time budget is over, or which is told to stop,
# is queued again and goes on from where it was. When all are done:
#     {merge}
#SBATCH --job-name={name}
#SBATCH --array=1-{shards}
#SBATCH --cpus-per-task={cpus}
#SBATCH --time={time}
#SBATCH --signal=B:TERM@{signal}
#SBATCH --requeue
#SBATCH --chdir="{folder}"
#SBATCH --output="slurm-%x-%A_%a.log"
#SBATCH --open-mode=append

# Slurm tells only this shell to stop. A signal also ends bash's wait, so the program is waited for again.
trap 'again=yes; kill -TERM $! 2>/dev/null' TERM
{command} --shard "$SLURM_ARRAY_TASK_ID/{shards}" --threads "$SLURM_CPUS_PER_TASK" &
while again=; wait $!; code=$?; [ "$again" ]; do :; done

# 75: there is more to do. A task that was cancelled, or that Slurm itself queues again, does not count as running any
# more. The bare number of the last task's job would mean the whole array.
if [ $code = 75 ]; then
    task=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
    for pause in 0 5 10 20 40; do
        sleep $pause
        state=$(squeue --noheader --states=all --format=%T --job="$task") && break
    done
    [ "$state" = RUNNING ] && echo "there is more to do: task $task is queued again" && scontrol requeue "$task"
fi
exit $code
