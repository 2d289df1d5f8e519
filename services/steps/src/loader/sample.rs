//! What the loader's sensors measured, as a sample.

use estimation::loader::Sample;
use messages::LoaderSensors as SensorsMessage;

use crate::rows::sample_of_message;

sheet::loader_signals!(sample_of_message);
