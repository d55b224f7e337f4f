// The weights of the method: four exchangeable files with the same functions.
#if subspaces
#import lib/weights_subspaces
#else
#if at_records
#import lib/weights_at_records
#else
#if resampling
#import lib/weights_records
#else
#import lib/weights_ratio
#endif
#endif
#endif
