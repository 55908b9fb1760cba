"""Race: what is flown: track, quadrotor, noise, controller settings and judge, each checked when it is made."""
