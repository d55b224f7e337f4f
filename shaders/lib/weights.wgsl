// The weights of the method: three exchangeable files with the same functions.
#if subspaces
#import lib/weights_subspaces
#else
#if resampling
#import lib/weights_records
#else
#import lib/weights_ratio
#endif
#endif
