# %% [markdown]
# # PPO in one file
#
# The loop in full, in the manner of CleanRL, on Gymnasium's vector interface: for those who change the algorithm. Run from the
# repository's root, with `pip install gymnasium torch` and the package (docs/python.md says how to build it). The algorithm and
# its constants are those of Schulman et al., "Proximal policy optimization algorithms", arXiv:1707.06347, with generalised
# advantage estimation (arXiv:1506.02438).

# %%
import numpy as np
import torch
from torch import nn

import oneiro
import oneiro.gym

UPDATES = 100
ENVIRONMENTS = 32
STEPS = 125
EPOCHS, MINIBATCHES = 4, 4
DISCOUNT, TRACE, CLIP, RATE = 0.99, 0.95, 0.2, 3e-4

torch.manual_seed(1)
# Networks as small as these are slower on several threads.
torch.set_num_threads(1)
exp = oneiro.Experiment.load("experiments/khepera-avoidance.toml")
envs = oneiro.gym.VectorEnv(exp, ENVIRONMENTS)
inputs, outputs = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]


def network(size):
    return nn.Sequential(nn.Linear(inputs, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, size))


actor, critic = network(outputs), network(1)
deviation = nn.Parameter(torch.zeros(outputs))
optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters(), deviation], lr=RATE)

# %% [markdown]
# With `NextStep` the step after an episode's end only begins the next one, whatever the action: such steps teach nothing, and are
# left out of the loss.


# %%
def policy(observations):
    return torch.distributions.Normal(actor(observations), deviation.exp())


observations = torch.as_tensor(envs.reset(seed=1)[0])
over = torch.zeros(ENVIRONMENTS)
finished = []
for _update in range(UPDATES):
    seen, taken, likely, rewards, values, ends, begins = [], [], [], [], [], [], []
    for _step in range(STEPS):
        with torch.no_grad():
            chosen = policy(observations)
            actions = chosen.sample()
            values.append(critic(observations)[:, 0])
        seen.append(observations)
        taken.append(actions)
        likely.append(chosen.log_prob(actions).sum(1))
        begins.append(over)
        after, reward, terminated, truncated, infos = envs.step(actions.clamp(-1, 1).numpy())
        observations = torch.as_tensor(after)
        rewards.append(torch.as_tensor(reward, dtype=torch.float32))
        over = torch.as_tensor(terminated | truncated, dtype=torch.float32)
        ends.append(over)
        if infos:
            finished.extend(infos["fitness"][infos["_fitness"]])
    # Advantages, from the last step back.
    with torch.no_grad():
        following = critic(observations)[:, 0]
    advantage, advantages = torch.zeros(ENVIRONMENTS), []
    for reward, value, end in zip(reversed(rewards), reversed(values), reversed(ends), strict=True):
        error = reward + DISCOUNT * following * (1 - end) - value
        advantage = error + DISCOUNT * TRACE * (1 - end) * advantage
        advantages.insert(0, advantage)
        following = value
    teaches = torch.cat(begins) == 0
    data = [torch.cat(own)[teaches] for own in (seen, taken, likely, advantages, values)]
    for _epoch in range(EPOCHS):
        for chosen in torch.randperm(len(data[0])).chunk(MINIBATCHES):
            seen_, taken_, likely_, gain, value_ = (own[chosen] for own in data)
            ratio = (policy(seen_).log_prob(taken_).sum(1) - likely_).exp()
            scaled = (gain - gain.mean()) / (gain.std() + 1e-8)
            actor_loss = -torch.min(ratio * scaled, ratio.clamp(1 - CLIP, 1 + CLIP) * scaled).mean()
            critic_loss = (critic(seen_)[:, 0] - (gain + value_)).square().mean()
            optimizer.zero_grad()
            (actor_loss + 0.5 * critic_loss).backward()
            nn.utils.clip_grad_norm_([*actor.parameters(), *critic.parameters(), deviation], 0.5)
            optimizer.step()

# %%
tenth = max(1, len(finished) // 10)
first, last = float(np.mean(finished[:tenth])), float(np.mean(finished[-tenth:]))
print(f"{len(finished)} episodes, mean fitness of the first tenth {first:.1f}, of the last {last:.1f}")
