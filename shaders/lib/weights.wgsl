// The weights of the method: two exchangeable files with the same functions.
#if subspaces
#import lib/weights_subspaces
#else
#import lib/weights_ratio
#endif
