"""Where does training data come from? Demonstrations, rollouts and interventions."""
