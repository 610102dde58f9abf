//! Earth, trajectories, strapdown, error covariance, Monte Carlo, grades and budgets.
